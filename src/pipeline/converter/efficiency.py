"""The efficiency of a converter at any load: the same at all of them, or from the losses of its parts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.records import Converter, ConverterLosses, Load, PowerChain, SwitchedConverter
from pipeline.jit import inlined, kernel

(
    FREQUENCY, INDUCTANCE, WINDING, SWITCH, RECTIFIER, FORWARD, ESR, SYNCHRONOUS,
    TRANSITION, NODE, GATE, DRIVER, CORE, CORE_RIPPLE, CORE_FREQUENCY, RIPPLE_POWER, FREQUENCY_POWER, CONTROL,
) = range(18)  # fmt: skip
"""Places of a converter's numbers."""

COLUMNS = (
    "duty", "ripple_a", "switch_w", "rectifier_w", "winding_w", "capacitor_w", "switching_w", "core_w", "control_w",
)  # fmt: skip
"""What is found of each load: duty, inductor ripple, and losses by path."""
_FIRST_LOSS, _END = 2, len(COLUMNS)
_loss_kernel_STEPS = 60
_SETTLED = 1e-12


@inlined
def _at_current(boosts: bool, parts: Array, source: float, sink: float, current: float, found: Array) -> float:
    """Fill in duty, ripple and losses at a mean inductor current; return the losses [W]."""
    switch, rectifier, winding, forward = parts[SWITCH], parts[RECTIFIER], parts[WINDING], parts[FORWARD]
    period, henry = 1.0 / parts[FREQUENCY], parts[INDUCTANCE]
    blocked = sink + forward if boosts else source + forward
    if boosts:
        duty = (blocked - source + current * (winding + rectifier)) / (blocked - current * (switch - rectifier))
        rising, falling = source - current * (switch + winding), blocked - source
    else:
        duty = (sink + forward + current * (winding + rectifier)) / (blocked - current * (switch - rectifier))
        rising, falling = source - sink - current * (switch + winding), sink + forward
    duty = min(max(duty, 0.0), 1.0)
    ripple, rest = max(rising, 0.0) * duty * period / henry, 1.0 - duty
    lowest = current - 0.5 * ripple
    if lowest < 0.0 and parts[SYNCHRONOUS] == 0.0 and rising > 0.0 and falling > 0.0:
        ratio = rising / falling
        duty = math.sqrt(2.0 * henry * max(current, 0.0) / (period * rising * (1.0 + ratio)))
        rest, ripple, lowest = duty * ratio, rising * duty * period / henry, 0.0
        square = ripple * ripple / 3.0
        carried = 0.5 * ripple * rest
    else:
        square = current * current + ripple * ripple / 12.0
        carried = current * rest
    output = carried if boosts else current
    into_output = square * rest if boosts else square * (duty + rest)
    found[0], found[1] = duty, ripple
    found[2] = switch * square * duty
    found[3] = rectifier * square * rest + forward * carried
    found[4] = winding * square * (duty + rest)
    found[5] = parts[ESR] * max(into_output - output * output, 0.0)
    edges = 0.5 * blocked * (max(lowest, 0.0) + lowest + ripple) * parts[TRANSITION]
    charged = 0.5 * parts[NODE] * blocked * blocked + parts[GATE] * parts[DRIVER]
    found[6] = (max(edges, 0.0) + charged) * parts[FREQUENCY]
    swing = (ripple / parts[CORE_RIPPLE]) ** parts[RIPPLE_POWER]
    found[7] = parts[CORE] * swing * (parts[FREQUENCY] / parts[CORE_FREQUENCY]) ** parts[FREQUENCY_POWER]
    found[8] = parts[CONTROL]
    total = 0.0
    for path in range(_FIRST_LOSS, _END):
        total += found[path]
    return total


@kernel
def fill_losses(boosts: bool, parts: Array, source: Array, sink: Array, power: Array, found: Array) -> None:
    """Fill in duty, ripple and losses of each load.

    Arguments
    ---------
    boosts : a boost converter, else a buck converter.
    parts : its numbers by place.
    source, sink : voltages at input and output [V], shape (n,).
    power : power at the input [W], shape (n,).
    found : the columns, filled in, shape (n, 9); where the power does not cover the losses, these are all of it.
    """
    for row in range(power.shape[0]):
        own = found[row]
        if boosts:
            _at_current(True, parts, source[row], sink[row], power[row] / source[row], own)
        else:
            current = power[row] / sink[row]
            for _ in range(_loss_kernel_STEPS):
                lost = _at_current(False, parts, source[row], sink[row], current, own)
                following = max(power[row] - lost, 0.0) / sink[row]
                moved = abs(following - current)
                current = following
                if moved <= _SETTLED * (1.0 + current):
                    break
        total = 0.0
        for path in range(_FIRST_LOSS, _END):
            total += own[path]
        if total > power[row]:
            share = power[row] / total if total > 0.0 else 0.0
            for path in range(_FIRST_LOSS, _END):
                own[path] *= share


Array = NDArray[np.float64]

CONDUCTION = ("switch_w", "rectifier_w", "winding_w", "capacitor_w")
"""The losses that follow from the resistances and forward voltages alone."""
_STEPS = 60


class Operation(NamedTuple):
    """A converter at some loads: column of `loss_kernel.COLUMNS` -> values, and input power [W], shape (n,) each."""

    columns: dict[str, Array]
    power_w: Array

    def losses_w(self, paths: tuple[str, ...] = COLUMNS[2:]) -> Array:
        """Return the sum of some losses, all of them without names [W], shape (n,)."""
        return np.asarray(sum(self.columns[path] for path in paths), dtype=np.float64)

    def efficiency(self, paths: tuple[str, ...] = COLUMNS[2:]) -> Array:
        """Return output over input power with some of the losses; 0 without power, shape (n,)."""
        lost = np.divide(self.losses_w(paths), self.power_w, out=np.ones_like(self.power_w), where=self.power_w > 0.0)
        return np.maximum(1.0 - lost, 0.0)


def boost_efficiency(chain: PowerChain, panel_voltage_v: ArrayLike, power_w: ArrayLike) -> Array:
    """Return the efficiency of the converter between panel and bus.

    Arguments
    ---------
    chain : the converters.
    panel_voltage_v : voltage of the panels [V], shape (n,) or one for all.
    power_w : power from the panels [W], shape (n,).

    Returns
    -------
    Output over input power [1], shape (n,).
    """
    power = np.atleast_1d(np.asarray(power_w, dtype=np.float64))
    if isinstance(chain.boost, Converter):
        return np.full_like(power, chain.boost.efficiency)
    return loads(chain, "boost", panel_voltage_v, chain.bus_voltage_v, power).efficiency()


def buck_efficiency(
    chain: PowerChain, battery_voltage_v: ArrayLike, power_w: ArrayLike, of_output: bool = False
) -> Array:
    """Return the efficiency of the converter between bus and battery.

    Arguments
    ---------
    chain : the converters.
    battery_voltage_v : voltage of the battery [V], shape (n,) or one for all.
    power_w : power from the bus, or into the battery [W], shape (n,).
    of_output : the power is that into the battery.

    Returns
    -------
    Output over input power [1], shape (n,).
    """
    power = np.atleast_1d(np.asarray(power_w, dtype=np.float64))
    if isinstance(chain.buck, Converter):
        return np.full_like(power, chain.buck.efficiency)
    if not of_output:
        return loads(chain, "buck", chain.bus_voltage_v, battery_voltage_v, power).efficiency()
    drawn, found = power, np.ones_like(power)
    for _ in range(_STEPS):
        at = loads(chain, "buck", chain.bus_voltage_v, battery_voltage_v, drawn)
        following = power + at.losses_w()
        # Losses that are more than what is drawn are cut to it, so that the power drawn goes on rising.
        settled = np.max(np.abs(following - drawn), initial=0.0) <= 1e-12 * np.max(power, initial=1.0)
        drawn = following
        if settled:
            break
    return np.divide(power, drawn, out=np.zeros_like(found), where=drawn > 0.0)


def loads(chain: PowerChain, which: str, source_v: ArrayLike, sink_v: ArrayLike, power_w: ArrayLike) -> Operation:
    """Return duty, ripple and losses of one of the converters from its parts.

    Arguments
    ---------
    which : `boost` or `buck`.
    source_v, sink_v : voltages at input and output [V], shape (n,) or one for all.
    power_w : power at the input [W], shape (n,).
    """
    assert chain.switched is not None
    assert chain.losses is not None
    boosts = which == "boost"
    stage: SwitchedConverter = chain.switched.boost if boosts else chain.switched.buck
    source, sink, power = (
        np.ascontiguousarray(part) for part in np.broadcast_arrays(*map(_float, (source_v, sink_v, power_w)))
    )
    found = np.zeros((power.size, len(COLUMNS)))
    fill_losses(boosts, numbers(stage, chain.losses.boost if boosts else chain.losses.buck), source, sink, power, found)
    return Operation(dict(zip(COLUMNS, found.T, strict=True)), power)


def numbers(stage: SwitchedConverter, losses: ConverterLosses) -> Array:
    """Return a converter's numbers in the order of `loss_kernel`."""
    synchronous = stage.rectifier == "synchronous"
    return np.array(
        [
            *(stage.switching_frequency_hz, stage.inductance_h, stage.inductor_resistance_ohm),
            *(stage.on_resistance_ohm, stage.rectifier_resistance_ohm),
            0.0 if synchronous else stage.rectifier_voltage_v,
            *(stage.capacitor_resistance_ohm, float(synchronous)),
            *(losses.transition_time_s, losses.node_capacitance_f, losses.gate_charge_c, losses.gate_voltage_v),
            *(losses.core_loss_w, losses.core_ripple_a, losses.core_frequency_hz),
            *(losses.ripple_exponent, losses.frequency_exponent, losses.control_power_w),
        ]
    )


def _float(values: ArrayLike) -> Array:
    return np.atleast_1d(np.asarray(values, dtype=np.float64))


Columns = dict[str, NDArray[np.float64]]


def battery_power(
    time_s: ArrayLike,
    irradiance_w_m2: ArrayLike,
    cell_temperature_c: ArrayLike,
    panel_power_w: ArrayLike,
    chain: PowerChain,
    load: Load,
    panel_voltage_v: ArrayLike = np.nan,
) -> Columns:
    """Follow the panel's maximum power to the battery: bus, less the load, through the buck converter.

    Arguments
    ---------
    time_s : starts of the intervals over which everything is constant [s], shape (n,).
    irradiance_w_m2, cell_temperature_c : the weather in each interval [W/m2], [degC], shape (n,).
    panel_power_w : maximum power of the panel [W], shape (n,).
    chain : tracker, boost and buck.
    load : the master system, served first.
    panel_voltage_v : voltage at that power, which a boost converter of parts depends on [V], shape (n,).

    Returns
    -------
    The columns of SUPPLY, shape (n,) each; where the load takes all, the battery's power is 0.
    """
    panel = np.asarray(panel_power_w, dtype=float)
    boost = boost_efficiency(chain, panel_voltage_v, panel * chain.tracker_efficiency)
    bus = panel * chain.tracker_efficiency * boost
    left = np.maximum(0.0, bus - load.power_w)
    buck = buck_efficiency(chain, chain.nominal_battery_voltage_v, left)
    return {
        "time_s": np.asarray(time_s, dtype=float),
        "irradiance_w_m2": np.asarray(irradiance_w_m2, dtype=float),
        "cell_temperature_c": np.asarray(cell_temperature_c, dtype=float),
        "panel_power_w": panel,
        "bus_power_w": bus,
        "load_power_w": np.full_like(panel, load.power_w),
        "battery_power_w": left * buck,
        "buck_efficiency": buck,
        "boost_efficiency": boost,
    }


def unserved_load_w(supply: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the part of the load the bus cannot serve [W], shape (n,); above 0 the battery gets nothing."""
    return np.maximum(0.0, supply["load_power_w"] - supply["bus_power_w"])
