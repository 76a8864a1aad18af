"""Ways to compare modes: as they are, with the same mean current, with some of their stops alone."""

from __future__ import annotations

from collections.abc import Collection

from pipeline.cell.records import Battery
from pipeline.charge.protocol import C_RATE, Resolver
from pipeline.charge.records import Mode
from pipeline.charge.waveforms import Reflex, Until, Waveform, of_battery
from pipeline.errors import UserError
from pipeline.record import Reference


def at_same_mean(mode: Mode, reference_current_a: float) -> Mode:
    """Return the mode with `charge_a` set so that a period's mean, voltage limit aside, is the reference.

    `charge_a = (reference + discharge_a discharge_share) / charge_share`. A mode without periodic phases comes back
    unchanged; one whose periodic phases would need different currents is refused.

    Arguments
    ---------
    reference_current_a : mean current of a period [A].

    Raises
    ------
    UserError : a share or discharge current is still to be found, or the phases do not agree.
    """
    needed = {
        name: _charge_current(mode, phase.waveform, f"phases.{name}", reference_current_a)
        for name, phase in mode.phases.items()
        if phase.waveform.periodic
    }
    if not needed:
        return mode
    if max(needed.values()) - min(needed.values()) > 1e-12 * max(needed.values()):
        raise UserError(f"phases need different charge_a for a mean of {reference_current_a:g} A: {needed}")
    knobs = {name: value for name, value in mode.knobs.items() if name != "charge" + C_RATE}
    fields = {name: getattr(mode, name) for name in mode.model_fields_set if name in Mode.model_fields}
    return Mode(**(fields | knobs | {"charge_a": next(iter(needed.values()))}))


def _charge_current(mode: Mode, waveform: Waveform, where: str, reference_current_a: float) -> float:
    if waveform.charge_a not in (None, "charge_a"):  # type: ignore[attr-defined]
        raise UserError(f"{where}.charge_a: takes {waveform.charge_a!r}, not the knob charge_a")  # type: ignore[attr-defined]
    resolver = Resolver(mode, 1.0)

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


def compared(mode: Mode, reference: Mode | None, battery: Battery, stops: Collection[str] | None = None) -> Mode:
    """Return a mode as it is run in a comparison: unchanged, with the mean current of a reference, with some stops."""
    mode = with_stops(mode, stops)
    if reference is None:
        return mode
    return at_same_mean(mode, constant_current_a(reference, battery))


def constant_current_a(mode: Mode, battery: Battery) -> float:
    """Return the constant current of a mode, before its voltage limit takes over.

    Returns
    -------
    The current of the first phase that has one [A].

    Raises
    ------
    UserError : no phase has a constant current, or it is still to be found.
    """
    resolver = Resolver(mode, battery.capacity_in_use_ah, battery.cells_in_series)
    for name, phase in mode.phases.items():
        for parameter in ("max_current_a", "current_a"):
            if parameter in type(phase.waveform).model_fields and parameter not in phase.waveform.optional:
                current = resolver.number(getattr(phase.waveform, parameter), parameter, f"phases.{name}.{parameter}")
                if isinstance(current, float):
                    return current
    raise UserError("phases: none has a constant current that is known, so no mean can be compared with it")
