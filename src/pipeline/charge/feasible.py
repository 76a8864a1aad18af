"""What a sheet comes to on a battery before it is run: the SOC it visits, what it cannot reach, unusual currents."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

from pipeline.cell.records import (
    Battery,
    Curve,
    Polynomial,
    SideReaction,
    Tabulated,
    curves_of,
    resting_voltage_v,
    value_of,
)
from pipeline.charge.protocol import Resolver, lift_of, parameters
from pipeline.charge.records import ChargeSettings, Mode, Phase
from pipeline.charge.waveforms import Controller
from pipeline.errors import UserError
from pipeline.record import Reference

# A potential may fall by this share from one SOC to a higher one, as measured tables do; and be this share of the full.
_MOST_FALL = 0.005
_LEAST_SHARE_OF_FULL = 1.0 / 3.0
_POINTS = 100
NEVER_FULL = 1.0 - 1e-6
"""As near to full as a battery comes that never fills [1]."""
_THERMAL_V_PER_K = 8.314462618 / 96485.33212
_ZERO_CELSIUS_K = 273.15
# Temperature of the numbers of a card, and how far from it their dependence matters.
_CARD_C, _FAR_K = 25.0, 10.0
# Share of a battery's voltage at rest that no current takes over a series resistance that is meant.
_LARGE_DROP = 0.5
_ROUNDED = 1e-9


def visited(battery: Battery, mode: Mode, settings: ChargeSettings) -> tuple[float, float]:
    """Return the lowest and the highest SOC that a charge may visit.

    Pulses that take out more than they put in may empty the battery.
    """
    empties, stop = emptied(Resolver(mode, battery.capacity_in_use_ah, battery.cells), mode)
    low = 0.0 if empties else settings.initial_soc
    return low, min(1.0, max(stop, low))


def emptied(resolver: Resolver, mode: Mode, margin: float = 0.0) -> tuple[bool, float]:
    """Tell whether pulses take out more than they put in, and at which SOC the charge is stopped; 1 without a stop.

    Arguments
    ---------
    margin : share by which they are taken to take out more than they do [1].
    """
    empties, stop = False, resolver.optional(mode.stop, "stop").get("soc", 1.0)
    for name, phase in mode.phases.items():
        if "discharge_a" not in type(phase.waveform).model_fields:
            continue
        found = parameters(resolver, phase.waveform, f"phases.{name}")
        numbers = {key: value for key, value in found.items() if not isinstance(value, Reference)}
        taken = numbers.get("discharge_a", 0.0) * numbers.get("discharge_share", 0.0)
        taken *= 1.0 + margin
        if taken > numbers.get("charge_a", math.inf) * numbers.get("charge_share", 1.0) > 0.0:
            empties = True
    return empties, 1.0 if isinstance(stop, Reference) else stop


def check_range(path: str, battery: Battery, low: float, high: float, temperature_c: float) -> None:
    """Check every curve of a battery over a range of SOC.

    The resting voltage must be finite, a third of that at the upper end or more, and may not fall on the way there;
    resistances must be finite and 0 or more, exchange currents finite and above 0.

    Arguments
    ---------
    path : key path of the battery, for the message.
    low, high : SOC from which and up to which a charge goes [1].
    temperature_c : at the start [degC].

    Raises
    ------
    UserError : with battery, key, SOC, value and what is allowed.
    """
    high = min(high, 1.0 if battery.fills else NEVER_FULL)
    looked_at = (id(battery), low, high, temperature_c)
    if looked_at in _SOUND:
        return
    _look(path, battery, low, high, temperature_c)
    while len(_SOUND) >= _MOST_SOUND:
        _SOUND.pop(next(iter(_SOUND)), None)
    _SOUND[looked_at] = battery


_SOUND: dict[tuple[int, float, float, float], Battery] = {}
"""What was looked at last and found sound: every mode of a study asks for the same, and every run of a sweep."""
_MOST_SOUND = 256


def _look(path: str, battery: Battery, low: float, high: float, temperature_c: float) -> None:
    for key, curve in curves_of(battery):
        unit = "V" if key.endswith("_v") else "V/K" if key.endswith("_v_k") else "A" if key.endswith("_a") else "ohm"
        for soc in _grid([curve], low, high):
            value = value_of(curve, soc)
            inside = 0.0 < soc < NEVER_FULL
            if not math.isfinite(value) or (unit == "ohm" and value < 0.0) or (unit == "A" and value <= 0.0 and inside):
                allowed = {"ohm": "0 or more", "A": "more than 0"}.get(unit, "a finite number")
                raise _refusal(path, key, battery, soc, value, unit, low, f"allowed is {allowed}")
    full = resting_voltage_v(battery, high, temperature_c)
    least, most, most_soc = _LEAST_SHARE_OF_FULL * full, -math.inf, low
    for soc in _grid([battery.open_circuit_voltage_v, battery.entropic_coefficient_v_k], low, high):
        volts = resting_voltage_v(battery, soc, temperature_c)
        if not volts > max(0.0, least):
            allowed = f"allowed is more than {max(0.0, least):.3g} V, a third of what it rests at when charged"
            raise _refusal(path, "open_circuit_voltage_v", battery, soc, volts, "V", low, allowed)
        if volts < most * (1.0 - _MOST_FALL):
            allowed = f"it may not fall while charging, and rests at {most:.4g} V at SOC {most_soc:.4g}"
            if isinstance(battery.open_circuit_voltage_v, Polynomial):
                allowed += "; a polynomial is one in 1 - SOC"
            raise _refusal(path, "open_circuit_voltage_v", battery, soc, volts, "V", low, allowed)
        if volts > most:
            most, most_soc = volts, soc


def _refusal(
    path: str, key: str, battery: Battery, soc: float, value: float, unit: str, low: float, allowed: str
) -> UserError:
    return UserError(
        f"{path}.{key}: {value:.4g} {unit} at SOC {soc:.4g} of {battery.name}, which a charge from SOC {low:g} visits; "
        f"{allowed}; change the curve or begin at another SOC"
    )


def _grid(curves: Sequence[Curve], low: float, high: float) -> list[float]:
    """Return the SOC at which some curves are looked at: both ends, points of tables, a grid where they bend freely."""
    found = {low, high}
    for curve in curves:
        if isinstance(curve, Tabulated):
            found |= {soc for soc in curve.inside[0] if low < soc < high}
        elif not isinstance(curve, float | int):
            found |= {low + (high - low) * n / _POINTS for n in range(_POINTS)}
    return sorted(found)


def check_resistance(where: str, battery: Battery, low: float, high: float) -> None:
    """Check that something in the battery lets a held voltage set a current at once.

    Raises
    ------
    UserError : no series resistance at some SOC, and no charge transfer.
    """
    if battery.charge_transfer is not None:
        return
    ohm = battery.series_resistance_ohm
    straight = isinstance(ohm, Polynomial) and len(ohm.polynomial) <= 2
    least, soc = min((value_of(ohm, soc), soc) for soc in ([low, high] if straight else _grid([ohm], low, high)))
    if least <= 0.0:
        raise UserError(
            f"{where}: {battery.name} has a series_resistance_ohm of {least:g} ohm at SOC {soc:.4g} and no "
            "charge_transfer, so that no current belongs to a voltage; give it more than 0"
        )


def notices(battery: Battery, mode: Mode, settings: ChargeSettings) -> Iterator[str]:
    """Yield what whoever plans a charge should know, each beginning with a key path below the mode.

    Voltages that the battery does not come to with the sheet's current, and currents outside its usual C-rates.
    """
    resolver = Resolver(mode, battery.capacity_in_use_ah, battery.cells)
    _, high = visited(battery, mode, settings)
    lift_v = battery.cells * lift_of(mode).per_cell_v(settings.start_c)
    names = list(mode.phases)
    for place, (name, phase) in enumerate(mode.phases.items()):
        found = parameters(resolver, phase.waveform, f"phases.{name}")
        numbers = {key: value for key, value in found.items() if not isinstance(value, Reference)}
        currents = _currents(phase, numbers)
        yield from _unusual(name, currents, battery)
        wanted = _wanted(resolver, name, phase, numbers)
        most_a = max(currents.values(), default=math.inf)
        yield from _dropped(name, currents, battery, high)
        if wanted is None or not math.isfinite(most_a) or len(currents) < len(_currents(phase, found)):
            continue
        key, volts = wanted
        reached = highest_v(battery, most_a, high, settings.start_c)
        if reached < volts + lift_v:
            after = f"; {', '.join(names[place + 1 :])} would not be reached" if names[place + 1 :] else ""
            waits = "; its current never falls" if phase.waveform.holds_voltage else ""
            yield (
                f"phases.{name}.{key}: {volts + lift_v:.4g} V is not reached: with {most_a:g} A "
                f"({most_a / battery.capacity_in_use_ah:.3g}C) {battery.name} comes to {reached:.4g} V at SOC {high:g}"
                f"{waits}{after}"
            )


def remarks(battery: Battery, settings: ChargeSettings) -> Iterator[str]:
    """Yield what is to be known of a battery's own numbers, each beginning with a key below the battery.

    That numbers are scaled with the capacity, and that resistances stay what they are in the cold or the heat.
    """
    ratio = battery.capacity_in_use_ah / battery.capacity_ah
    if abs(ratio - 1.0) > _ROUNDED:
        yield (
            f"scaled_to_capacity_ah: {battery.capacity_in_use_ah:g} Ah; every other number of {battery.name} is that "
            f"of {battery.capacity_ah:g} Ah: its resistances count {1.0 / ratio:.3g} times, its heat capacity "
            f"{ratio:.3g} times"
        )
    temperatures_c = (settings.ambient_c, settings.start_c)
    farthest_c = max(temperatures_c, key=lambda one: abs(one - _CARD_C))
    if abs(farthest_c - _CARD_C) > _FAR_K and not any(battery.warmths):
        yield (
            f"series_resistance_temperature: none; at {farthest_c:g} degC the resistances of {battery.name} are those "
            f"of {_CARD_C:g} degC, so that it takes its charge as it does there"
        )


def highest_v(battery: Battery, current_a: float, soc: float, temperature_c: float) -> float:
    """Return the terminal voltage that a battery comes to with a current at an SOC, its pairs filled [V].

    What it does not accept any more goes to the side reaction, which bounds the voltage where there is one.
    """
    amperes, kelvin = current_a / battery.scale, temperature_c + _ZERO_CELSIUS_K
    ohm = value_of(battery.series_resistance_ohm, soc)
    node_v = value_of(battery.open_circuit_voltage_v, soc)
    node_v += value_of(battery.entropic_coefficient_v_k, soc) * (temperature_c - 25.0)
    node_v += sum(amperes * value_of(pair.resistance_ohm, soc) for pair in battery.pairs.values())
    if battery.acceptance is not None:
        node_v += amperes * battery.acceptance.resistance_ohm / (1.0 - soc) if soc < 1.0 else math.inf
    if battery.hysteresis is not None:
        node_v += battery.hysteresis.amplitude_v
    if battery.charge_transfer is not None:
        exchange = value_of(battery.charge_transfer.exchange_current_a, soc)
        scale = 2.0 * _THERMAL_V_PER_K * kelvin
        node_v += scale * math.asinh(amperes / (2.0 * exchange)) if exchange > 0.0 else math.inf
    if battery.side_reaction is not None:
        node_v = min(node_v, _side_v(battery.side_reaction, amperes, kelvin))
    return battery.cells_in_series * (node_v + ohm * amperes)


def _side_v(side: SideReaction, amperes: float, kelvin: float) -> float:
    """Return the voltage of a cell at which the side reaction takes a current [V]."""
    scale = side.voltage_scale_v or _THERMAL_V_PER_K * kelvin * (side.thermal_voltages or 0.0)
    reference_k = side.reference_temperature_c + _ZERO_CELSIUS_K
    arrhenius = side.activation_energy_j_mol / 8.314462618 / (kelvin * reference_k)
    warmth = (kelvin - reference_k) * (side.temperature_coefficient_per_k + arrhenius)
    return side.reference_voltage_v + scale * (math.log(amperes / side.current_a) - warmth)


def _currents(phase: Phase, values: Mapping[str, object]) -> dict[str, float]:
    """Return the charging currents of a phase by name; a limit that nobody gave is none."""
    optional = {name for name in phase.waveform.optional if getattr(phase.waveform, name) is None}
    return {
        key: value  # type: ignore[misc]
        for key, value in values.items()
        if key.split(".")[0].endswith("_a") and key != "discharge_a" and key not in optional
    }


def _unusual(name: str, currents: Mapping[str, float], battery: Battery) -> Iterator[str]:
    if battery.usual_c_rate is None:
        return
    low, high = battery.usual_c_rate
    rates = {key: value / battery.capacity_in_use_ah for key, value in currents.items()}
    # A trickle is meant to be less than a charge.
    beyond = {
        key: max(rate / high, low / rate if key != "trickle_a" else 0.0)
        for key, rate in rates.items()
        if rate > high * (1.0 + 1e-9) or (rate < low * (1.0 - 1e-9) and key != "trickle_a")
    }
    for of, keys in itertools.groupby(beyond, key=lambda key: key.split(".")[0]):
        group = list(keys)
        key = max(group, key=beyond.__getitem__)
        more = f", and {len(group) - 1} more of {of} are unusual" if len(group) > 1 else ""
        yield (
            f"phases.{name}.{key}: {currents[key]:.4g} A is {rates[key]:.3g}C of {battery.name}; "
            f"usual are {low:g}C to {high:g}C, "
            f"{low * battery.capacity_in_use_ah:.4g} to {high * battery.capacity_in_use_ah:.4g} A{more}"
        )


def _dropped(name: str, currents: Mapping[str, float], battery: Battery, soc: float) -> Iterator[str]:
    """Yield where a current takes as much over the series resistance as the battery has: a slip of the unit."""
    key = max(currents, key=currents.__getitem__, default="")
    if not key or not math.isfinite(currents[key]):
        return
    drop_v = battery.cells_in_series * value_of(battery.series_resistance_ohm, soc) * currents[key] / battery.scale
    own_v = resting_voltage_v(battery, soc, _CARD_C)
    if drop_v > _LARGE_DROP * own_v:
        yield (
            f"phases.{name}.{key}: {currents[key]:.4g} A takes {drop_v:.3g} V over the series resistance of "
            f"{battery.name}, which has {own_v:.3g} V at rest; series_resistance_ohm is that of a cell, in ohm"
        )


def _wanted(resolver: Resolver, name: str, phase: Phase, numbers: Mapping[str, float]) -> tuple[str, float] | None:
    """Return the voltage that a phase waits for: one that it holds, that ends it, or that its tail current needs."""
    if isinstance(phase.waveform, Controller):
        return None
    limit = resolver.optional(phase.limit, f"phases.{name}.limit").get("voltage_v")
    until = resolver.optional(phase.until, f"phases.{name}.until")
    if phase.waveform.holds_voltage and "voltage_v" in numbers:
        return "voltage_v", numbers["voltage_v"] if not isinstance(limit, float) else min(limit, numbers["voltage_v"])
    reached = until.get("voltage_v")
    if isinstance(reached, float):
        return "until.voltage_v", reached
    if "current_a" in until and isinstance(limit, float):
        return "limit.voltage_v", limit
    return None
