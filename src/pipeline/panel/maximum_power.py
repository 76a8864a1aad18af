"""Maximum power of the fitted panel for arrays of conditions, compiled.

The laws of irradiance and temperature are those of the CEC model (Dobos 2012, DOI 10.1115/1.4005759); the current is
explicit in the diode's voltage, and so are the conditions for open circuit, short circuit and maximum power.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import UserError
from pipeline.jit import inlined, kernel
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, Panel
from pipeline.panel.single_diode import (
    BAND_GAP_EV,
    BAND_GAP_SLOPE_PER_K,
    BOLTZMANN_EV_PER_K,
    REFERENCE_TEMPERATURE_K,
    SingleDiode,
)

STRAIGHT_STEPS = 3
SETTLED = 1e-5
"""Last step of third order, relative to the ideality, after which no more than rounding is left."""
NEAR = 0.5
"""Steps, relative to the ideality, that the short exponential takes."""
_MOST_STEPS = 100
_QUADRATIC = 1e-8
_TERMS = 12
_INVERSE = (0.0, *(1.0 / order for order in range(1, _TERMS + 1)))


@inlined
def _near_exponential(x: float) -> float:
    """Return exp(x) for |x| below a half or so, to rounding: without a branch or a call, so that it vectorises."""
    total = 1.0
    for order in range(_TERMS, 0, -1):
        total = 1.0 + x * _INVERSE[order] * total
    return total


@inlined
def _step(
    total: float, grown: float, voltage: float, series: float, conductance: float, per_v: float
) -> tuple[float, float]:
    """Return Halley's step in the diode voltage towards dP/dV_d = 0, and that slope.

    Arguments
    ---------
    total : photocurrent and saturation current [A]; grown : saturation current times exp(V_d / a) [A].
    per_v : 1 / a [1/V].
    """
    bend = grown * per_v
    slope = bend + conductance
    current = total - grown - voltage * conductance
    outside = voltage - 2.0 * current * series
    rise = current - slope * outside
    widens = 1.0 + 2.0 * series * slope
    first = -slope - bend * per_v * outside - slope * widens
    second = -bend * per_v * (1.0 + 2.0 * widens + 2.0 * series * slope + per_v * outside)
    return -rise * first / (first * first - 0.5 * rise * second), rise


@kernel
def fill_maximum(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    start: Array,
    grown: Array,
    series: float,
    current: Array,
    voltage: Array,
    last: Array,
) -> None:
    """Fill in the maximum power after three steps; vectorised, since nothing in it depends on a comparison.

    Arguments
    ---------
    photo, saturation, conductance, ideality : parameters of each condition [A], [A], [S], [V], shape (n,).
    start : diode voltage to begin with over the ideality; grown : saturation current times its exponential [A].
    series : series resistance [ohm].
    current, voltage : terminal current and voltage at maximum power, filled in.
    last : last step over the ideality, filled in; 1 where a step was too long for its exponential.
    """
    for here in range(photo.shape[0]):
        per_v = 1.0 / ideality[here]
        total, shunt = photo[here] + saturation[here], conductance[here]
        inside, diode_current = start[here] * ideality[here], grown[here]
        moved, farthest = 0.0, 0.0
        for _ in range(STRAIGHT_STEPS):
            step, _rise = _step(total, diode_current, inside, series, shunt, per_v)
            moved = abs(step * per_v)
            farthest = max(farthest, moved)
            inside += step
            diode_current *= _near_exponential(step * per_v)
        found = total - diode_current - inside * shunt
        current[here] = found
        voltage[here] = inside - found * series
        last[here] = moved if farthest <= NEAR else 1.0


@kernel
def refill_maximum(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    series: float,
    current: Array,
    voltage: Array,
    last: Array,
) -> None:
    """Find those again that three steps did not settle, between short and open circuit; arguments as above."""
    for here in range(photo.shape[0]):
        if abs(last[here]) <= SETTLED:
            continue
        per_v, total = 1.0 / ideality[here], photo[here] + saturation[here]
        low, high = 0.0, ideality[here] * math.log1p(photo[here] / saturation[here])
        inside = 0.5 * high
        for _ in range(_MOST_STEPS):
            grown = saturation[here] * math.exp(inside * per_v)
            step, rise = _step(total, grown, inside, series, conductance[here], per_v)
            if rise > 0.0:
                low = inside
            else:
                high = inside
            following = inside + step
            if not low <= following <= high:
                following = 0.5 * (low + high)
            step, inside = following - inside, following
            if abs(step) * per_v <= SETTLED**2:
                break
        found = total - saturation[here] * math.exp(inside * per_v) - inside * conductance[here]
        current[here] = found
        voltage[here] = inside - found * series
        last[here] = 0.0


@kernel
def fill_ends(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    series: float,
    short_a: Array,
    open_v: Array,
) -> None:
    """Fill in short-circuit current and open-circuit voltage by Newton's method; arguments as above.

    The current is concave in the diode voltage and falls: from above, every step to open circuit stays above.
    """
    for here in range(photo.shape[0]):
        short_a[here], open_v[here] = 0.0, 0.0
        if photo[here] <= 0.0:
            continue
        total, per_v = photo[here] + saturation[here], 1.0 / ideality[here]
        voltage = ideality[here] * math.log(total / saturation[here])
        for _ in range(_MOST_STEPS):
            grown = saturation[here] * math.exp(voltage * per_v)
            step = (total - grown - voltage * conductance[here]) / (grown * per_v + conductance[here])
            voltage += step
            if abs(step) * per_v <= _QUADRATIC:
                break
        open_v[here] = voltage
        short_a[here] = total - saturation[here]
        if series > 0.0:
            voltage = min(total * series / (1.0 + series * conductance[here]), voltage)
            for _ in range(_MOST_STEPS):
                grown = saturation[here] * math.exp(voltage * per_v)
                off = (total - grown - voltage * conductance[here]) * series - voltage
                step = off / (1.0 + series * (grown * per_v + conductance[here]))
                voltage += step
                if abs(step) <= _QUADRATIC * voltage:
                    break
            short_a[here] = voltage / series


Array = NDArray[np.float64]

ZERO_CELSIUS_K = 273.15


class Points(NamedTuple):
    """Maximum power and the ends of the curve of one panel in each condition, shape (n,) each; zero in the dark."""

    max_power_current_a: Array
    max_power_voltage_v: Array
    max_power_w: Array
    short_circuit_current_a: Array
    open_circuit_voltage_v: Array


class MaximumPower(NamedTuple):
    """Maximum power of one panel in each condition, shape (n,) each; zero in the dark."""

    max_power_current_a: Array
    max_power_voltage_v: Array
    max_power_w: Array


class Conditions(NamedTuple):
    """Parameters of the single-diode circuit in each condition, shape (n,) each."""

    photocurrent_a: Array
    saturation_current_a: Array
    shunt_conductance_s: Array
    modified_ideality_v: Array


def conditions(
    panel: Panel, diode: SingleDiode, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Conditions:
    """Return the parameters of one panel in each condition; arguments and errors as for `characteristic_points`."""
    suns, cells = np.broadcast_arrays(
        np.atleast_1d(np.asarray(irradiance_w_m2, dtype=np.float64)) / REFERENCE_IRRADIANCE_W_M2,
        np.atleast_1d(np.asarray(cell_temperature_c, dtype=np.float64)),
    )
    _check("irradiance_w_m2", suns, suns >= 0.0, REFERENCE_IRRADIANCE_W_M2, "0 and above")
    _check("cell_temperature_c", cells, cells > -ZERO_CELSIUS_K, 1.0, f"above {-ZERO_CELSIUS_K:g}")
    kelvin = cells + ZERO_CELSIUS_K
    ratio, rise = kelvin / REFERENCE_TEMPERATURE_K, kelvin - REFERENCE_TEMPERATURE_K
    gap = BAND_GAP_EV * (1.0 + BAND_GAP_SLOPE_PER_K * rise)
    exponent = (BAND_GAP_EV / REFERENCE_TEMPERATURE_K - gap / kelvin) / BOLTZMANN_EV_PER_K
    alpha = panel.alpha_isc_a_per_k * (1.0 - diode.adjust_percent / 100.0)
    return Conditions(
        np.maximum(suns * (diode.photocurrent_a + alpha * rise), 0.0),
        diode.saturation_current_a * (ratio * ratio * ratio) * np.exp(exponent),
        suns / diode.shunt_resistance_ohm,
        diode.modified_ideality_v * ratio,
    )


def maximum_of(found: Conditions, series_resistance_ohm: float) -> MaximumPower:
    """Return the maximum power from the parameters of each condition.

    Three of Halley's steps from the maximum of a panel without shunt, V + a ln(1 + (V - 2 R_s I_L)/a) = V_oc, once put
    into itself; they settle all but odd panels, whose conditions are then found one by one.

    Arguments
    ---------
    found : parameters.
    series_resistance_ohm : series resistance, the same in all conditions [ohm].
    """
    photo, saturation, conductance, ideality = (np.ascontiguousarray(part).ravel() for part in found)
    total = photo + saturation
    height = np.log(total / saturation)
    share = np.maximum(1.0 - 2.0 * series_resistance_ohm * photo / ideality + height, 1.0)
    current, voltage, last = np.empty((3, photo.size))
    series = float(series_resistance_ohm)
    start = height - np.log(share)
    fill_maximum(photo, saturation, conductance, ideality, start, total / share, series, current, voltage, last)
    if not np.all(np.abs(last) <= SETTLED):
        refill_maximum(photo, saturation, conductance, ideality, series, current, voltage, last)
    shape = found.photocurrent_a.shape
    return MaximumPower(*(part.reshape(shape) for part in (current, voltage, current * voltage)))


def maximum_power(
    panel: Panel, diode: SingleDiode, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> MaximumPower:
    """Return the maximum power of one panel over conditions; arguments and errors as for `characteristic_points`."""
    found = conditions(panel, diode, irradiance_w_m2, cell_temperature_c)
    return maximum_of(found, diode.series_resistance_ohm)


def characteristic_points(
    panel: Panel, diode: SingleDiode, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Points:
    """Return maximum power, short circuit and open circuit of one panel over conditions.

    Arguments
    ---------
    panel : the data sheet; its temperature coefficient of the current.
    diode : fitted parameters of one panel.
    irradiance_w_m2, cell_temperature_c : conditions, broadcast against each other [W/m2], [degC], shape (n,).

    Raises
    ------
    UserError : an irradiance below zero or a temperature at or below absolute zero, or one that is not finite.
    """
    found = conditions(panel, diode, irradiance_w_m2, cell_temperature_c)
    ends = np.empty((2, found.photocurrent_a.size))
    flat = [np.ascontiguousarray(part).ravel() for part in found]
    fill_ends(flat[0], flat[1], flat[2], flat[3], float(diode.series_resistance_ohm), ends[0], ends[1])
    shape = found.photocurrent_a.shape
    return Points(*maximum_of(found, diode.series_resistance_ohm), *(part.reshape(shape) for part in ends))


def _check(name: str, values: Array, allowed: NDArray[np.bool_], unit: float, words: str) -> None:
    good = allowed & np.isfinite(values)
    if not good.all():
        raise UserError(f"{name}: value {unit * values[~good].flat[0]:g}; allowed is {words}, and finite")
