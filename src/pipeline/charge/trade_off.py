"""Charge time against peak temperature, over constant currents, stops, conditions, and sampled modes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate
from pipeline.charge.trade_off_records import CONSTANT, OWN, TIMER, Condition, Sensor, TradeOff
from pipeline.charge.waveforms import Sampled


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

    def charged(law: str, mode: Mode, condition: str, rate: float = math.nan, stop: str = "", sensor: str = "") -> Row:
        settings = _settings(charge, chosen.conditions[condition], chosen.full_soc)
        return _row(battery, mode, settings, engine, Row(law, rate, stop, condition, sensor, *_BLANK))

    rows = [
        charged(CONSTANT, mode, condition, rate, stop)
        for condition in chosen.conditions
        for rate, stop, mode in _constants(chosen)
    ]
    rows += [
        charged(name, mode, condition, sensor=OWN) for condition in chosen.conditions for name, mode in sampled.items()
    ]
    rows += [
        charged(name, behind(mode, sensor), first, sensor=of)
        for of, sensor in chosen.sensors.items()
        for name, mode in sampled.items()
    ]
    return rows


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


def _row(battery: Battery, mode: Mode, settings: ChargeSettings, engine: EngineSettings, blank: Row) -> Row:
    summary = {row.quantity: row for row in simulate(battery, mode, BENCH, settings, engine).summary}

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
