"""Does a mode fit the battery and the conditions? What needs several records is checked here, before anything runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.charge.feasible import check_range, check_resistance, visited
from pipeline.charge.protocol import MOST_C_RATE, Resolver, lift_of, parameters
from pipeline.charge.records import ChargeSettings, Mode, Phase
from pipeline.charge.waveforms import (
    ConstantCurrent,
    ConstantPower,
    ConstantVoltage,
    Rest,
    Sampled,
    Staged,
    Until,
    Waveform,
)
from pipeline.errors import UserError, best_matches
from pipeline.record import Number, Reference

MOST_SAMPLES = 20_000_000
SHORTEST_SAMPLE_S = 1e-3
MOST_SAMPLES_A_SPAN = 100_000
WATCHED = ("voltage_drop_v", "temperature_rate_k_s")


def check_sampled(where: str, values: Mapping[str, float], stop_s: float) -> None:
    """Check the sensor and the currents of a sampled controller.

    Arguments
    ---------
    where : key path of the phase.
    values : its parameters; one still to be found is left out.
    stop_s : time at which the charge is given up [s].

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    interval, span = values.get("sample_interval_s"), values.get("rate_span_s", 0.0)
    if interval is None:
        return
    if interval < SHORTEST_SAMPLE_S:
        raise UserError(f"{where}.sample_interval_s: {interval:g} s; allowed is {SHORTEST_SAMPLE_S:g} s or more")
    if stop_s / interval > MOST_SAMPLES:
        raise UserError(
            f"{where}.sample_interval_s: {interval:g} s up to stop.elapsed_s {stop_s:g} s are more than "
            f"{MOST_SAMPLES} samples"
        )
    samples = round(span / interval)
    if span > 0.0 and (samples < 1 or abs(samples * interval - span) > 1e-9 * span or samples > MOST_SAMPLES_A_SPAN):
        raise UserError(
            f"{where}.rate_span_s: {span:g} s is no whole number of samples of {interval:g} s, "
            f"from 1 to {MOST_SAMPLES_A_SPAN}; give a multiple, or 0 for one sample"
        )
    if values.get("trickle_a", 0.0) >= values.get("fast_a", math.inf):
        raise UserError(f"{where}.trickle_a: {values['trickle_a']:g} A is not below fast_a, {values['fast_a']:g} A")
    stream = values.get("noise_stream", 0.0)
    if stream != int(stream):
        raise UserError(f"{where}.noise_stream: {stream:g}; allowed is a whole number, 0 or more")


def check_watched(mode: Mode) -> None:
    """Check that nobody watches for a falling voltage or a rising rate where pulses make them by themselves.

    Raises
    ------
    UserError : with the key path.
    """
    pulsed = [name for name, phase in mode.phases.items() if phase.waveform.periodic]
    places = [(f"phases.{name}.until", mode.phases[name].until, name in pulsed) for name in mode.phases]
    for where, until, wrong in [*places, ("stop", mode.stop, bool(pulsed))]:
        for name in WATCHED:
            if wrong and name in until.given:
                raise UserError(f"{where}.{name}: needs a steady current; pulses change voltage and heat by themselves")
    sampled = [phase.waveform for phase in mode.phases.values() if isinstance(phase.waveform, Sampled)]
    if any(other != sampled[0] for other in sampled[1:]):
        raise UserError("phases: a mode has one controller; those of its phases differ")


SHORTEST_SEGMENT_S = 1e-6
# Beyond these a number has the wrong unit: no charger goes there, and values in mV or mA are far beyond.
NEARLY_EMPTY, NEARLY_FULL = 0.01, 0.99
LEAST_SHARE_OF_EMPTY, MOST_SHARE_OF_FULL = 0.5, 2.0
MOST_COURSES = 100_000


class Facts(NamedTuple):
    """What a sheet is held against: a battery's capacity and cells, its voltages at rest, the start of the charge.

    start_v, empty_v, full_v : at the start, and nearly empty and full at its temperature [V].
    warm_full_v : nearly full at 25 degC [V].
    lift_v : what the temperature at the start adds to the voltages of the sheet [V].
    """

    capacity_in_use_ah: float
    cells: int
    fills: bool
    initial_soc: float
    start_c: float
    whose: str
    sample_interval_s: float
    start_v: float
    empty_v: float
    full_v: float
    warm_full_v: float
    lift_v: float


def facts_of(battery: Battery, mode: Mode, settings: ChargeSettings) -> Facts:
    """Return what a mode is held against."""
    start_c = settings.start_c
    return Facts(
        battery.capacity_in_use_ah,
        battery.cells,
        battery.fills,
        settings.initial_soc,
        start_c,
        "ambient's" if settings.initial_temperature_c is None else "battery's at the start,",
        settings.sample_interval_s,
        resting_voltage_v(battery, settings.initial_soc, start_c),
        resting_voltage_v(battery, NEARLY_EMPTY, start_c),
        resting_voltage_v(battery, NEARLY_FULL, start_c),
        resting_voltage_v(battery, NEARLY_FULL, 25.0),
        battery.cells * lift_of(mode).per_cell_v(start_c),
    )


def check(battery: Battery, mode: Mode, settings: ChargeSettings) -> None:
    """Check that a mode can be run; a number that another step is still to find is taken to be right.

    Raises
    ------
    UserError : with the key path below the mode, the value and what is allowed.
    """
    resolver = check_sheet(mode, facts_of(battery, mode, settings))
    low, high = visited(battery, mode, settings)
    check_range("battery", battery, low, high, settings.start_c)
    for name, phase in mode.phases.items():
        if needs_resistance(phase):
            check_resistance(f"phases.{name}", battery, low, high)
    unused = sorted(set(mode.knobs) - resolver.used)
    if unused:
        wanted = _known_names(mode)
        raise UserError(f"{unused[0]}: no phase uses this knob; {best_matches(unused[0], wanted)}")


def needs_resistance(phase: Phase) -> bool:
    """Tell whether a phase holds a voltage, to which a current must belong."""
    return phase.waveform.holds_voltage or "voltage_v" in phase.limit.given


def check_sheet(mode: Mode, facts: Facts) -> Resolver:
    """Check a mode against what is known of battery and conditions; return what it was looked up with.

    Every comparison is with a straight line in each of the facts, so that a mode which passes for the least and for the
    largest of each passes between.

    Raises
    ------
    UserError : as `check`.
    """
    resolver = Resolver(mode, facts.capacity_in_use_ah, facts.cells)
    stop = _numbers(resolver.optional(mode.stop, "stop"))
    for name, phase in mode.phases.items():
        _check_phase(resolver, f"phases.{name}", phase, facts)
        if isinstance(phase.waveform, Sampled):
            values = _numbers(parameters(resolver, phase.waveform, f"phases.{name}"))
            check_sampled(f"phases.{name}", values, stop.get("elapsed_s", 0.0))
    _check_until("stop", stop, facts)
    _check_ends(mode, stop, facts)
    _check_charges(resolver, mode, facts)
    _check_begun(resolver, mode, stop, facts)
    check_watched(mode)
    return resolver


def _check_phase(resolver: Resolver, where: str, phase: Phase, facts: Facts) -> None:
    waveform = phase.waveform
    values = _numbers(parameters(resolver, waveform, where))
    for name, value in values.items():
        if value != waveform.optional.get(name):
            _check_value(f"{where}.{name}", name.split(".")[0], value)
            _check_current(f"{where}.{name}", name.split(".")[0], value, facts)
    if isinstance(waveform, Staged):
        _check_stages(where, waveform)
    if waveform.periodic:
        _check_period(where, waveform, values)
    for path, limit in _voltages(resolver, where, phase).items():
        _check_voltage(path, limit, facts)
    until = _numbers(resolver.optional(phase.until, f"{where}.until"))
    _check_until(f"{where}.until", until, facts)
    if "current_a" in phase.until.given:
        if not isinstance(waveform, ConstantVoltage | ConstantCurrent | ConstantPower):
            raise UserError(f"{where}.until.current_a: only a constant current, voltage or power can end by current")
        if not _voltages(resolver, where, phase):
            raise UserError(
                f"{where}.until.current_a: the current falls where a voltage is held, and nothing holds one; "
                "give limit.voltage_v"
            )


def _voltages(resolver: Resolver, where: str, phase: Phase) -> dict[str, float]:
    """Return the voltages that a phase keeps to, held or limiting, by key path; open ones are left out."""
    limit = _numbers(resolver.optional(phase.limit, f"{where}.limit"))
    found = {f"{where}.limit.{name}": value for name, value in limit.items()}
    if phase.waveform.holds_voltage:
        values = _numbers(parameters(resolver, phase.waveform, where))
        found |= {f"{where}.voltage_v": values["voltage_v"]} if "voltage_v" in values else {}
    return found


def _check_charges(resolver: Resolver, mode: Mode, facts: Facts) -> None:
    """Refuse a sheet of which no phase charges the battery it begins with: all their voltages are below its own."""
    resting, lift_v = facts.start_v, facts.lift_v
    low: dict[str, float] = {}
    for name, phase in mode.phases.items():
        if isinstance(phase.waveform, Rest):
            continue
        below = {key: v for key, v in _voltages(resolver, f"phases.{name}", phase).items() if v + lift_v <= resting}
        if not below:
            return
        low |= below
    if low:
        path, limit = next(iter(low.items()))
        lifted = f" ({limit + lift_v:g} V at its temperature)" if lift_v else ""
        raise UserError(
            f"{path}: {limit:g} V{lifted} does not charge a battery that rests at {resting:.2f} V "
            f"(SOC {facts.initial_soc:g}, {facts.start_c:g} degC); give more"
        )


def _check_value(path: str, name: str, value: float) -> None:
    if name.endswith("_share"):
        lowest = 0.0 if name == "discharge_share" else 1e-9
        if not lowest <= value <= 1.0:
            raise UserError(f"{path}: {value:g} is not a share of the period; allowed is 0 to 1")
    elif value < 0.0 or (value == 0.0 and name != "discharge_a"):
        raise UserError(f"{path}: {value:g}; it must be greater than 0")


def _check_current(path: str, name: str, value: float, facts: Facts) -> None:
    most = MOST_C_RATE * facts.capacity_in_use_ah
    if name.endswith("_a") and value > most:
        raise UserError(
            f"{path}: {value:g} A is {value / facts.capacity_in_use_ah:g} C of {facts.capacity_in_use_ah:g} Ah; "
            f"allowed is up to {MOST_C_RATE:g} C, {most:g} A"
        )
    most *= facts.warm_full_v
    if name.endswith("_w") and value > most:
        raise UserError(f"{path}: {value:g} W; allowed is up to {MOST_C_RATE:g} C at the battery's voltage, {most:g} W")


def _check_voltage(path: str, value: float, facts: Facts) -> None:
    least, most = max(0.0, LEAST_SHARE_OF_EMPTY * facts.empty_v), MOST_SHARE_OF_FULL * facts.full_v
    if not least <= value <= most:
        raise UserError(
            f"{path}: {value:g} V for a battery that rests at {facts.full_v:.2f} V when full; "
            f"allowed is {least:.2f} to {most:.2f} V"
        )


def _check_stages(where: str, waveform: Staged) -> None:
    edges = waveform.soc_edges
    if not isinstance(waveform.currents_a, Reference) and len(edges) != len(waveform.currents_a):
        raise UserError(f"{where}.soc_edges: {len(edges)} edges for {len(waveform.currents_a)} currents; give one each")
    if any(after <= before for before, after in zip([0.0, *edges], edges, strict=False)) or edges[-1] >= 1.0:
        raise UserError(f"{where}.soc_edges: {edges}; they must rise, between 0 and 1")


def _check_period(where: str, waveform: Waveform, values: Mapping[str, float]) -> None:
    shares = {name: value for name, value in values.items() if name.endswith("_share")}
    if sum(shares.values()) > 1.0 + 1e-12:
        said = " + ".join(f"{name} {value:g}" for name, value in shares.items())
        raise UserError(f"{where}: {said} is more than the period; the shares may add up to 1")
    wanted = {name for name, _ in waveform}
    if wanted <= set(values):
        for segment in waveform.segments(values):
            if segment.length_s < SHORTEST_SEGMENT_S:
                raise UserError(
                    f"{where}.frequency_hz: at {values['frequency_hz']:g} Hz a segment lasts {segment.length_s:.3g} s; "
                    f"allowed is {SHORTEST_SEGMENT_S:g} s or more"
                )


def _check_until(where: str, until: Mapping[str, float], facts: Facts) -> None:
    for name, value in until.items():
        if name != "temperature_c" and value <= 0.0:
            raise UserError(f"{where}.{name}: {value:g}; it must be greater than 0")
        if name == "elapsed_s" and value < SHORTEST_SEGMENT_S:
            raise UserError(f"{where}.{name}: {value:g} s; allowed is {SHORTEST_SEGMENT_S:g} s or more")
    if "voltage_v" in until:
        _check_voltage(f"{where}.voltage_v", until["voltage_v"], facts)
    soc = until.get("soc", 0.5)
    if soc > 1.0 or (soc == 1.0 and not facts.fills):
        raise UserError(f"{where}.soc: {soc:g} is never reached; give {'1 or less' if facts.fills else 'less than 1'}")


def _check_ends(mode: Mode, stop: Mapping[str, float], facts: Facts) -> None:
    if mode.stop.elapsed_s is None:
        raise UserError("stop.elapsed_s: missing; a charge needs a time at which it is given up")
    if stop.get("soc", 1.0) <= facts.initial_soc:
        raise UserError(f"stop.soc: {stop['soc']:g} is not above initial_soc {facts.initial_soc:g}")
    if stop.get("elapsed_s", 0.0) / facts.sample_interval_s > MOST_SAMPLES:
        raise UserError(
            f"stop.elapsed_s: {stop['elapsed_s']:g} s at a sample every {facts.sample_interval_s:g} s "
            f"makes more than {MOST_SAMPLES} rows"
        )
    if mode.repeat * len(mode.phases) > MOST_COURSES:
        raise UserError(
            f"repeat: {mode.repeat} times {len(mode.phases)} phases are too many; allowed are {MOST_COURSES}"
        )
    names = list(mode.phases)
    followed = names if mode.repeat > 1 else names[:-1]
    for name in followed:
        phase = mode.phases[name]
        if not isinstance(phase.waveform, Staged) and phase.until == Until():
            raise UserError(f"phases.{name}.until: missing; without an end what follows is never reached")


def _check_begun(
    resolver: Resolver,
    mode: Mode,
    stop: Mapping[str, float],
    facts: Facts,
) -> None:
    """Refuse what is over as it begins: the charge itself, all of its phases, currents never above theirs.

    A single phase that is over is skipped, as chargers do, and the outcome says so.
    """
    resting = facts.start_v - facts.lift_v
    over: list[str] = []
    for name, phase in mode.phases.items():
        where = f"phases.{name}.until"
        until = _numbers(resolver.optional(phase.until, where))
        over += [] if isinstance(phase.waveform, Rest) else [_met_at_rest(where, until, resting, facts)]
    for told in (_met_at_rest("stop", stop, resting, facts), over[0] if over and all(over) else ""):
        if told:
            raise UserError(told)
    largest = {name: _largest_a(resolver, name, phase) for name, phase in mode.phases.items()}
    ends = {
        f"phases.{name}.until": (_numbers(resolver.optional(phase.until, f"phases.{name}.until")), largest[name])
        for name, phase in mode.phases.items()
    } | {"stop": (stop, max(largest.values()))}
    for where, (limits, most) in ends.items():
        if limits.get("current_a", -1.0) >= most:
            raise UserError(
                f"{where}.current_a: {limits['current_a']:g} A, but the current is never above {most:g} A; give less"
            )


def _met_at_rest(where: str, limits: Mapping[str, float], resting_v: float, facts: Facts) -> str:
    """Return which limit a battery at rest is beyond, in words; empty where there is none."""
    if limits.get("voltage_v", math.inf) <= resting_v:
        return (
            f"{where}.voltage_v: {limits['voltage_v']:g} V is met at the start, where the battery rests at "
            f"{resting_v:.2f} V; give more"
        )
    if limits.get("soc", 1.0) <= facts.initial_soc:
        soc = limits["soc"]
        return f"{where}.soc: {soc:g} is met at the start, initial_soc {facts.initial_soc:g}; give more"
    if limits.get("temperature_c", math.inf) <= facts.start_c:
        return (
            f"{where}.temperature_c: {limits['temperature_c']:g} degC is not above the {facts.whose} {facts.start_c:g}"
        )
    return ""


def _largest_a(resolver: Resolver, name: str, phase: Phase) -> float:
    """Return the largest current of a phase as far as it is known, else infinity [A]."""
    found = parameters(resolver, phase.waveform, f"phases.{name}")
    currents = [value for key, value in found.items() if key.split(".")[0].endswith("_a")]
    if not currents or any(isinstance(value, Reference) for value in currents) or isinstance(phase.waveform, Sampled):
        return 0.0 if isinstance(phase.waveform, Rest) else math.inf
    return max(float(value) for value in currents if not isinstance(value, Reference))


def _numbers(values: Mapping[str, Number]) -> dict[str, float]:
    return {name: value for name, value in values.items() if not isinstance(value, Reference)}


def _known_names(mode: Mode) -> set[str]:
    names = {"title", "phases", "repeat", "stop"}
    for phase in mode.phases.values():
        names |= {name for name, _ in phase.waveform}
    return names
