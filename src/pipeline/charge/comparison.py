"""Ways to compare modes: as they are, at the same peak or mean current, with some of their stops alone."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from pipeline.cell.records import Battery
from pipeline.charge.protocol import C_RATE, Resolver
from pipeline.charge.records import Mode
from pipeline.charge.waveforms import Reflex, Until, Waveform, of_battery
from pipeline.errors import UserError
from pipeline.record import Reference

# Currents that charge, the largest of which is a mode's peak; where they are scaled, so is what discharges.
_CHARGING = ("current_a", "max_current_a", "charge_a", "fast_a", "currents_a")
_SCALED = (*_CHARGING, "discharge_a")


class Level(NamedTuple):
    """Whose current sets that of every mode: the reference mode, and whether its peak or its mean is taken."""

    reference: Mode
    mean: bool


def level_of(card: Mapping[str, Any], modes: Mapping[str, Mode]) -> Level | None:
    """Return the level of a comparison as its settings hold it: the name of a mode, or none, and whether its mean."""
    return None if card["reference"] is None else Level(modes[card["reference"]], card["mean"])


def compared(mode: Mode, level: Level | None, battery: Battery, stops: Collection[str] | None = None) -> Mode:
    """Return a mode as it is run in a comparison: unchanged, at the current of a reference, with some stops.

    Raises
    ------
    UserError : a current that is needed for it is still to be found, or the reference has none.
    """
    mode = with_stops(mode, stops)
    if level is None:
        return mode
    factor = scale(mode, level, battery)
    if factor != 1.0:
        mode = _times(mode, factor)
    if not level.mean:
        return mode
    return at_same_mean(mode, constant_current_a(level.reference, battery), battery.capacity_in_use_ah)


def scale(mode: Mode, level: Level, battery: Battery) -> float:
    """Return by how much a comparison multiplies all currents of a mode, before the mean of its pulses is set.

    At the same peak the largest charging current becomes that of the reference; at the same mean the constant current
    does, which is all there is of it beside pulses. A mode whose current is decided as it runs, or is given by a power,
    has none to scale.

    Returns
    -------
    The factor; 1 where nothing is changed [1].

    Raises
    ------
    UserError : a current is still to be found, or the reference has none.
    """
    of = constant_a if level.mean else peak_current_a
    wanted, own = of(level.reference, battery), of(mode, battery)
    if wanted is None:
        raise UserError("phases: none has a constant current that is known, so no other can be set to it")
    if own is None or abs(wanted - own) <= 1e-12 * own:
        return 1.0
    return wanted / own


def _times(mode: Mode, factor: float) -> Mode:
    """Return the mode with every current of its waveforms, knob or number, times a factor."""
    knobs, shared = dict(mode.knobs), set()
    phases = {}
    for name, phase in mode.phases.items():
        changed: dict[str, Any] = {}
        for parameter in (name for name in _SCALED if name in type(phase.waveform).model_fields):
            value = getattr(phase.waveform, parameter)
            of_list = value if isinstance(value, list) else [value]
            numbers = [factor * one if isinstance(one, float | int) else one for one in of_list]
            changed[parameter] = numbers if isinstance(value, list) else numbers[0]
            for wanted in (parameter if one is None else one for one in of_list):
                if isinstance(wanted, str):
                    shared |= {wanted, wanted.removesuffix("_a") + C_RATE} & set(knobs)
        waveform = phase.waveform.model_copy(update=changed)
        phases[name] = phase.model_copy(update={"waveform": waveform})
    for name in shared:
        knob = knobs[name]
        knobs[name] = knob if isinstance(knob, Reference) else factor * knob
    return _with(mode, phases=phases, **knobs)


def _with(mode: Mode, **changed: Any) -> Mode:
    """Return the mode with phases or knobs replaced; a knob that is not named is left out."""
    fields = {name: getattr(mode, name) for name in mode.model_fields_set if name in Mode.model_fields}
    return Mode(**(fields | changed))


def at_same_mean(mode: Mode, reference_current_a: float, capacity_in_use_ah: float) -> Mode:
    """Return the mode with `charge_a` set so that a period's mean, voltage limit aside, is the reference.

    `charge_a = (reference + discharge_a discharge_share) / charge_share`. A mode without periodic phases comes back
    unchanged; one whose periodic phases would need different currents is refused.

    Arguments
    ---------
    reference_current_a : mean current of a period [A].
    capacity_in_use_ah : for a discharge given as a C-rate [A h].

    Raises
    ------
    UserError : a share or discharge current is still to be found, or the phases do not agree.
    """
    resolver = Resolver(mode, capacity_in_use_ah)
    needed = {
        name: _charge_current(resolver, phase.waveform, f"phases.{name}", reference_current_a)
        for name, phase in mode.phases.items()
        if phase.waveform.periodic
    }
    if not needed:
        return mode
    if max(needed.values()) - min(needed.values()) > 1e-12 * max(needed.values()):
        raise UserError(f"phases need different charge_a for a mean of {reference_current_a:g} A: {needed}")
    knobs = {name: value for name, value in mode.knobs.items() if name != "charge" + C_RATE}
    return _with(mode, **(knobs | {"charge_a": next(iter(needed.values()))}))


def _charge_current(resolver: Resolver, waveform: Waveform, where: str, reference_current_a: float) -> float:
    if waveform.charge_a not in (None, "charge_a"):  # type: ignore[attr-defined]
        raise UserError(f"{where}.charge_a: takes {waveform.charge_a!r}, not the knob charge_a")  # type: ignore[attr-defined]

    def number(name: str) -> float:
        value = resolver.number(getattr(waveform, name), name, f"{where}.{name}")
        if isinstance(value, Reference) or value is None:
            raise UserError(f"{where}.{name}: still to be found; the mean current needs its number")
        return value

    discharged = number("discharge_a") * number("discharge_share") if isinstance(waveform, Reflex) else 0.0
    return (reference_current_a + discharged) / number("charge_share")


def with_stops(mode: Mode, stops: Collection[str] | None) -> Mode:
    """Return a mode that heeds only some of its stops, always the time at which it is given up; None for all of them.

    What ends a phase stays: a mode without an end that is not its own would be another mode.
    """
    if stops is None:
        return mode
    kept = {name: value for name, value in mode.stop if of_battery(name)[0] in {*stops, "elapsed_s"}}
    return mode.model_copy(update={"stop": Until(**kept)})


def constant_a(mode: Mode, battery: Battery) -> float | None:
    """Return the constant current of a mode, before its voltage limit takes over; None where it has none [A].

    Raises
    ------
    UserError : it is still to be found.
    """
    found = _currents_a(mode, battery, ("max_current_a", "current_a"))
    return found[0] if found else None


def constant_current_a(mode: Mode, battery: Battery) -> float:
    """Return the constant current of the first phase that has one [A].

    Raises
    ------
    UserError : no phase has a constant current, or it is still to be found.
    """
    found = constant_a(mode, battery)
    if found is None:
        raise UserError("phases: none has a constant current that is known, so no mean can be compared with it")
    return found


def peak_current_a(mode: Mode, battery: Battery) -> float | None:
    """Return the largest charging current that a mode asks for; None where it has no current of its own [A].

    Raises
    ------
    UserError : one is still to be found.
    """
    return max(_currents_a(mode, battery, _CHARGING), default=None)


def _currents_a(mode: Mode, battery: Battery, parameters: Collection[str]) -> list[float]:
    resolver = Resolver(mode, battery.capacity_in_use_ah, battery.cells)
    found: list[float] = []
    for name, phase in mode.phases.items():
        for parameter in (one for one in parameters if one in type(phase.waveform).model_fields):
            where, value = f"phases.{name}.{parameter}", getattr(phase.waveform, parameter)
            if value is None and parameter in phase.waveform.optional and not resolver.holds(parameter):
                continue
            for one in value if isinstance(value, list) else [value]:
                current = one if isinstance(one, Reference) else resolver.number(one, parameter, where)
                if isinstance(current, Reference):
                    raise UserError(f"{where}: still to be found; a comparison at the same current needs its number")
                found += [] if current is None else [current]
    return found
