"""What a tracker works on: the panels and the converter behind them, as numbers for the closed loop."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.records import SwitchedBoost
from pipeline.jit import inlined
from pipeline.panel.maximum_power import characteristic_points, conditions, maximum_power
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C, Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker.records import Scales

Array = NDArray[np.float64]


class Source(NamedTuple):
    """The panels and the boost converter that sets their voltage against a stiff bus.

    Arguments
    ---------
    panel : the data sheet, with the number of panels.
    diode : single-diode parameters of one panel.
    boost : the parts of the converter.
    bus_voltage_v : voltage of the bus [V].
    """

    panel: Panel
    diode: SingleDiode
    boost: SwitchedBoost
    bus_voltage_v: float


def scales(source: Source) -> Scales:
    """Return what the settings of a tracker are relative to."""
    points = characteristic_points(source.panel, source.diode, REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C)
    return Scales(
        float(points.open_circuit_voltage_v[0]) * source.panel.panels_in_series,
        float(points.short_circuit_current_a[0]) * source.panel.panels_in_parallel,
        source.bus_voltage_v,
    )


def parts(source: Source) -> Array:
    """Return the circuit's values in the order of `circuit_kernel`."""
    boost = source.boost
    diode = boost.rectifier == "diode_emulated"
    return np.array(
        [
            *(boost.inductance_h, boost.input_capacitance_f, source.bus_voltage_v),
            boost.rectifier_voltage_v if diode else 0.0,
            *(boost.inductor_resistance_ohm, boost.on_resistance_ohm, boost.rectifier_resistance_ohm),
            *(boost.switching_period_s, float(diode)),
        ]
    )


def of_all_panels(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> tuple[Array, float]:
    """Return the single-diode parameters of all panels in each condition, shape (4, n), and their resistance [ohm]."""
    one = conditions(source.panel, source.diode, irradiance_w_m2, cell_temperature_c)
    series, parallel = source.panel.panels_in_series, source.panel.panels_in_parallel
    rows = np.array(
        [
            one.photocurrent_a * parallel,
            one.saturation_current_a * parallel,
            one.shunt_conductance_s * parallel / series,
            one.modified_ideality_v * series,
        ]
    )
    return rows, source.diode.series_resistance_ohm * series / parallel


def available_power_w(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> Array:
    """Return the maximum power of all panels in each condition [W], shape (n,)."""
    one = maximum_power(source.panel, source.diode, irradiance_w_m2, cell_temperature_c)
    return one.max_power_w * (source.panel.panels_in_series * source.panel.panels_in_parallel)


FIRST_STEP_S = 0.0005
GROWTH = 3.0
"""First step after a change, and by how much each further one is longer, until the next change."""
_MOST_NEWTON_STEPS = 40
_FAR = 40.0
INDUCTANCE, CAPACITANCE, BUS, DROP, SERIES, SWITCH, RECTIFIER, PERIOD, DIODE = range(9)
"""Places of inductance, input capacitance, bus voltage, forward voltage, resistances of inductor, switch and
rectifier, length of a switching period, and whether the rectifier is a diode."""


@inlined
def panel_current(
    photo: float, saturation: float, shunt: float, ideality: float, series: float, voltage: float, guess: float
) -> tuple[float, float, float]:
    """Return current [A], -dI/dV [S] and diode voltage [V] of all panels at a terminal voltage.

    Arguments
    ---------
    photo, saturation, shunt, ideality, series : single-diode parameters [A], [A], [S], [V], [ohm].
    voltage : terminal voltage [V].
    guess : diode voltage to begin with [V].
    """
    total, per_v = photo + saturation, 1.0 / ideality
    inside = min(guess, voltage + series * total)
    grown, slope = 0.0, 0.0
    for _ in range(_MOST_NEWTON_STEPS):
        grown = saturation * math.exp(inside * per_v)
        slope = grown * per_v + shunt
        step = (voltage + series * (total - grown - inside * shunt) - inside) / (1.0 + series * slope)
        inside += step
        share = step * per_v
        if abs(share) < 1e-5:
            grown *= 1.0 + share
            break
    slope = grown * per_v + shunt
    return total - grown - inside * shunt, slope / (1.0 + series * slope), inside


@inlined
def tabled_current(curve: Array, step_v: float, voltage: float) -> tuple[float, float]:
    """Return current [A] and -dI/dV [S] from a curve at equal steps of the voltage, shape (m,)."""
    place = min(max(int(voltage / step_v), 0), curve.shape[0] - 2)
    slope = (curve[place] - curve[place + 1]) / step_v
    return curve[place] - slope * (voltage - place * step_v), slope


@inlined
def circuit_step(
    voltage: float, inductor: float, current: float, conductance: float, duty: float, parts: Array, length: float
) -> tuple[float, float]:
    """Return panel voltage [V] and inductor current [A] after a step.

    Arguments
    ---------
    voltage, inductor : at its start.
    current, conductance : of the panel there [A], [S].
    duty : of the converter.
    parts : the circuit's values by place.
    length : of the step [s].
    """
    henry, farad, bus = parts[INDUCTANCE], parts[CAPACITANCE], parts[BUS] + parts[DROP]
    rest = 1.0 - duty
    ohm = parts[SERIES] + duty * parts[SWITCH] + rest * parts[RECTIFIER]
    push = voltage - rest * bus - ohm * inductor
    of_voltage, of_current = 1.0, -ohm
    if parts[DIODE] > 0.0 and voltage > 0.0 and bus > voltage:
        factor = 2.0 * henry / (parts[PERIOD] * duty)
        if factor * inductor < voltage:
            push = factor * inductor * (1.0 - bus / voltage) + bus * duty - ohm * inductor
            of_voltage = factor * inductor * bus / (voltage * voltage)
            of_current = factor * (1.0 - bus / voltage) - ohm
    rate_v, rate_i = (current - inductor) / farad, push / henry
    a, b, c, d = -conductance / farad, -1.0 / farad, of_voltage / henry, of_current / henry
    half, product = 0.5 * (a + d), a * d - b * c
    same, along = _exponential(half, half * half - product, length)
    # exp(hJ) - 1 = (same - 1) + along (J - half)
    moved_v = (same - 1.0) * rate_v + along * ((a - half) * rate_v + b * rate_i)
    moved_i = (same - 1.0) * rate_i + along * (c * rate_v + (d - half) * rate_i)
    found_v = voltage + (d * moved_v - b * moved_i) / product
    found_i = inductor + (a * moved_i - c * moved_v) / product
    return max(found_v, 0.0), max(found_i, 0.0) if parts[DIODE] > 0.0 else found_i


@inlined
def _exponential(half: float, square: float, length: float) -> tuple[float, float]:
    """Return the weights of 1 and of J - half in exp(J length), from half the trace and the square of the roots."""
    if square < 0.0:
        root = math.sqrt(-square)
        if half * length < -_FAR:
            return 0.0, 0.0
        size = math.exp(half * length)
        return size * math.cos(root * length), size * math.sin(root * length) / root
    root = math.sqrt(square) + 1e-9
    slow, fast = math.exp((half + root) * length), math.exp((half - root) * length)
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / root
