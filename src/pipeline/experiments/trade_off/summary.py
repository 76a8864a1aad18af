"""The trade-off in numbers: what the network reaches, and who else reaches it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, Task, simulate_many
from pipeline.charge.waveforms import Sampled
from pipeline.experiments.trade_off.records import (
    CONSTANT,
    OWN,
    SAME_TIME,
    TIMER,
    TRADE_OFF_NUMBERS,
    WHO,
    Condition,
    Sensor,
    TradeOff,
)
from pipeline.quantity import Quantity


class Row(NamedTuple):
    """One charge of the trade-off; a number is NaN where there is none or the charge did not get there."""

    law: str
    c_rate: float
    stop: str
    condition: str
    sensor: str
    time_to_full_s: float
    peak_temperature_c: float
    end_time_s: float
    end_soc: float
    charge_in_share: float
    end_reason: str


def trade_off(
    battery: Battery, modes: Mapping[str, Mode], charge: ChargeSettings, engine: EngineSettings, chosen: TradeOff
) -> list[Row]:
    """Charge by every constant current under every stop, and by every mode that samples, in every condition.

    Arguments
    ---------
    modes : modes by name; those that do not sample are left out.
    charge : settings whose sampling interval is taken.

    Returns
    -------
    A row a charge: constant currents first, then the modes, then the modes behind other sensors.
    """
    sampled = {name: mode for name, mode in modes.items() if samples(mode)}
    first = next(iter(chosen.conditions))
    asked = [
        (Row(CONSTANT, rate, stop, condition, "", *_BLANK), mode)
        for condition in chosen.conditions
        for rate, stop, mode in _constants(chosen)
    ]
    asked += [
        (Row(name, math.nan, "", condition, OWN, *_BLANK), mode)
        for condition in chosen.conditions
        for name, mode in sampled.items()
    ]
    asked += [
        (Row(name, math.nan, "", first, of, *_BLANK), behind(mode, sensor))
        for of, sensor in chosen.sensors.items()
        for name, mode in sampled.items()
    ]
    settings = {name: _settings(charge, one, chosen.full_soc) for name, one in chosen.conditions.items()}
    done = simulate_many(Task(battery, mode, BENCH, settings[row.condition], engine) for row, mode in asked)
    return [_row(battery, charged, settings[row.condition], row) for (row, _), charged in zip(asked, done, strict=True)]


def samples(mode: Mode) -> bool:
    """Tell whether a mode has a sampled controller."""
    return any(isinstance(phase.waveform, Sampled) for phase in mode.phases.values())


def behind(mode: Mode, sensor: Sensor) -> Mode:
    """Return a mode with another sensor, by its knobs."""
    knobs = sensor.model_dump(exclude={"title"})
    return Mode.model_validate(mode.model_dump(mode="json", by_alias=True) | knobs)


_BLANK = (math.nan, math.nan, math.nan, math.nan, math.nan, "")


def _constants(chosen: TradeOff) -> Iterator[tuple[float, str, Mode]]:
    for rate in chosen.c_rates:
        hour_s = 3600.0 / rate
        stops = {name: stop.model_dump(exclude_none=True) for name, stop in chosen.stops.items()}
        for name, stop in (stops | {TIMER: {"elapsed_s": chosen.timer_share * hour_s}}).items():
            given = {"elapsed_s": chosen.give_up_share * hour_s} | stop
            sheet = {
                "title": CONSTANT,
                "current_c_rate": rate,
                "phases": {"charge": {"constant_current": {}}},
                "stop": given,
            }
            yield rate, name, Mode.model_validate(sheet)


def _settings(charge: ChargeSettings, condition: Condition, full_soc: float) -> ChargeSettings:
    return charge.model_copy(
        update={
            "ambient_c": condition.ambient_c,
            "initial_soc": condition.initial_soc,
            "soc_marks": [full_soc],
            "windows": [],
        }
    )


def _row(battery: Battery, charged: Charge, settings: ChargeSettings, blank: Row) -> Row:
    summary = {row.quantity: row for row in charged.summary}

    def number(name: str) -> float:
        value = summary[name].value
        return math.nan if value is None else value

    return blank._replace(
        time_to_full_s=number(f"time_to_soc_{settings.soc_marks[0]:g}_s"),
        peak_temperature_c=number("peak_temperature_c"),
        end_time_s=number("end_time_s"),
        end_soc=number("end_soc"),
        charge_in_share=number("charge_in_ah") / battery.capacity_in_use_ah,
        end_reason=(summary["end_reason"].text or "").removeprefix("stop: "),
    )


def quantities(rows: Sequence[Row], chosen: TradeOff) -> list[Quantity]:
    """Return the named numbers of a trade-off; those of a mode that was not charged are left out.

    Arguments
    ---------
    rows : its charges.
    chosen : its settings, which name the modes that stand for the network and the rule.
    """
    found: list[Quantity] = []
    for condition in chosen.conditions:
        here = [row for row in rows if row.condition == condition]
        constants = [row for row in here if row.law == CONSTANT and not math.isnan(row.time_to_full_s)]
        for who, law in (("network", chosen.candidate), ("rule", chosen.rule)):
            for row in (one for one in here if one.law == law and one.sensor == OWN):
                found += _reached(who, condition, row)
                named = {"mode": who, "condition": condition}
                found.append(TRADE_OFF_NUMBERS.quantity("{mode}_charge_in_{condition}", row.charge_in_share, **named))
                if who == "network":
                    found += _rivals(condition, row, constants)
    for sensor in chosen.sensors:
        found += _behind(rows, sensor, chosen)
    first = next(iter(chosen.conditions))
    for row in (one for one in rows if one.law == CONSTANT and one.condition == first):
        ended = {"rate": f"{row.c_rate:g}", "stop": row.stop, "reason": row.end_reason}
        found.append(TRADE_OFF_NUMBERS.quantity("constant_{rate}c_ended_by_{stop}_s", row.end_time_s, **ended))
    return found


def _rivals(condition: str, network: Row, constants: Sequence[Row]) -> Iterator[Quantity]:
    """Yield the fastest constant current that gets no hotter than the network, and the coolest that is no slower."""
    no_hotter = [row for row in constants if row.peak_temperature_c <= network.peak_temperature_c]
    if no_hotter:
        rival = min(no_hotter, key=lambda row: (round(row.time_to_full_s, 3), row.peak_temperature_c))
        yield from _reached("rival", condition, rival)
        yield _current("rival", condition, rival)
    no_slower = [row for row in constants if row.time_to_full_s <= (1.0 + SAME_TIME) * network.time_to_full_s]
    if no_slower:
        coolest = min(no_slower, key=lambda row: (row.peak_temperature_c, row.time_to_full_s))
        yield from _reached("coolest", condition, coolest)
        yield _current("coolest", condition, coolest)


def _current(rival: str, condition: str, row: Row) -> Quantity:
    named = {"rival": rival, "condition": condition, "reason": row.end_reason}
    return TRADE_OFF_NUMBERS.quantity("{rival}_c_rate_{condition}", row.c_rate, **named)


def _reached(who: str, condition: str, row: Row) -> Iterator[Quantity]:
    named = {"who": who, "condition": condition, "words": WHO[who]}
    yield TRADE_OFF_NUMBERS.quantity("{who}_time_to_full_{condition}_s", row.time_to_full_s, **named)
    yield TRADE_OFF_NUMBERS.quantity("{who}_peak_{condition}_c", row.peak_temperature_c, **named)


def _behind(rows: Sequence[Row], sensor: str, chosen: TradeOff) -> Iterator[Quantity]:
    for row in (one for one in rows if one.sensor == sensor):
        who = "network" if row.law == chosen.candidate else "rule" if row.law == chosen.rule else ""
        if who:
            named = {"mode": who, "sensor": sensor, "words": WHO[who]}
            yield TRADE_OFF_NUMBERS.quantity("{mode}_time_to_full_behind_{sensor}_s", row.time_to_full_s, **named)
        if who == "network":
            yield TRADE_OFF_NUMBERS.quantity("network_peak_behind_{sensor}_c", row.peak_temperature_c, sensor=sensor)
        if who == "rule":
            yield TRADE_OFF_NUMBERS.quantity("rule_end_soc_behind_{sensor}", row.end_soc, sensor=sensor)
