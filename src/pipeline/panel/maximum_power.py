"""Maximum power of the fitted panel for arrays of conditions, compiled.

The laws of irradiance and temperature are those of the CEC model (Dobos 2012, DOI 10.1115/1.4005759); the current is
explicit in the diode's voltage, and so are the conditions for open circuit, short circuit and maximum power.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import UserError
from pipeline.panel.equivalent import BAND_GAP_EV, BAND_GAP_SLOPE_PER_K, BOLTZMANN_EV_PER_K, REFERENCE_TEMPERATURE_K
from pipeline.panel.maximum_power_kernel import SETTLED, fill_ends, fill_maximum, refill_maximum
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, Panel
from pipeline.panel.single_diode import SingleDiode

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
