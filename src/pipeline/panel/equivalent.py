"""The single-diode equivalent circuit, explicit in its diode voltage, with the CEC laws of temperature.

Dobos, "An improved coefficient calculator for the California Energy Commission 6 parameter photovoltaic module
model", J. Sol. Energy Eng. 134 (2012) 021011, DOI 10.1115/1.4005759; De Soto, Klein and Beckman, Sol. Energy 80 (2006)
78, DOI 10.1016/j.solener.2005.06.010.
"""

from __future__ import annotations

import math
from typing import NamedTuple

BOLTZMANN_EV_PER_K = 8.617333262e-5
REFERENCE_TEMPERATURE_K = 298.15
BAND_GAP_EV = 1.121  # silicon at 25 degC
BAND_GAP_SLOPE_PER_K = -0.0002677


class SingleDiode(NamedTuple):
    """Parameters of one panel at 1000 W/m2 and 25 degC; `modified_ideality_v` is n N_s k T / q."""

    photocurrent_a: float
    saturation_current_a: float
    series_resistance_ohm: float
    shunt_resistance_ohm: float
    modified_ideality_v: float
    adjust_percent: float


def at_temperature(diode: SingleDiode, alpha_isc_a_per_k: float, temperature_k: float) -> SingleDiode:
    """Return the parameters at another cell temperature and 1000 W/m2.

    Arguments
    ---------
    diode : parameters at 25 degC.
    alpha_isc_a_per_k : the data sheet's coefficient of the short-circuit current [A/K], before its adjustment.
    temperature_k : cell temperature [K].

    Returns
    -------
    Parameters at that temperature; the resistances do not change (Dobos 2012, eq. 8-12).
    """
    ratio = temperature_k / REFERENCE_TEMPERATURE_K
    rise_k = temperature_k - REFERENCE_TEMPERATURE_K
    band_gap_ev = BAND_GAP_EV * (1.0 + BAND_GAP_SLOPE_PER_K * rise_k)
    exponent = (BAND_GAP_EV / REFERENCE_TEMPERATURE_K - band_gap_ev / temperature_k) / BOLTZMANN_EV_PER_K
    return diode._replace(
        photocurrent_a=diode.photocurrent_a + alpha_isc_a_per_k * (1.0 - diode.adjust_percent / 100.0) * rise_k,
        saturation_current_a=diode.saturation_current_a * ratio**3 * math.exp(exponent),
        modified_ideality_v=diode.modified_ideality_v * ratio,
    )


def current(diode: SingleDiode, diode_voltage_v: float) -> float:
    """Return the terminal current [A] at a diode voltage [V]; the terminal voltage is that less R_s times it."""
    recombination = diode.saturation_current_a * math.expm1(diode_voltage_v / diode.modified_ideality_v)
    return diode.photocurrent_a - recombination - diode_voltage_v / diode.shunt_resistance_ohm


def conductance(diode: SingleDiode, diode_voltage_v: float) -> float:
    """Return -dI/dV of the diode and the shunt together [S] at a diode voltage [V]."""
    ideality_v = diode.modified_ideality_v
    slope = diode.saturation_current_a / ideality_v * math.exp(diode_voltage_v / ideality_v)
    return slope + 1.0 / diode.shunt_resistance_ohm


def max_power_w(diode: SingleDiode) -> float:
    """Return the maximum power [W]: the root of dP/dV_d along the curve, which is explicit in V_d."""
    from scipy.optimize import brentq

    def slope(diode_voltage_v: float) -> float:
        current_a = current(diode, diode_voltage_v)
        lost_v = 2.0 * current_a * diode.series_resistance_ohm
        return current_a - conductance(diode, diode_voltage_v) * (diode_voltage_v - lost_v)

    ideality_v = diode.modified_ideality_v
    no_current_v = ideality_v * math.log1p(diode.photocurrent_a / diode.saturation_current_a)
    diode_voltage_v = brentq(slope, 0.0, no_current_v, xtol=1e-12, rtol=1e-14)
    current_a = current(diode, diode_voltage_v)
    return current_a * (diode_voltage_v - current_a * diode.series_resistance_ohm)
