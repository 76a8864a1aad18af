"""The fit of the single-diode model to a data sheet: six parameters, six equations, no library entry needed."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.panel.records import Panel

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


__all__ = ["SingleDiode", "deviations", "fit"]

_OPEN_CIRCUIT_RISE_K = 5.0
_POWER_TEMPERATURES_K = (263.15, 323.15)  # the coefficient is the mean slope from -10 to 50 degC, as in SAM
_FIRST_IDEALITIES = (1.0, 1.1, 0.9, 1.2, 1.35, 1.5)
_FIRST_RESISTANCE_SHARES = (1.0, 0.5, 1.5)
_SHORT_CIRCUIT_FACTORS = tuple(1.01**times for times in range(6))
_ACCEPTED = 1e-8


class Deviations(NamedTuple):
    """By how much each fitted equation is missed, relative to the data sheet's own value."""

    short_circuit: float
    open_circuit: float
    max_power_point: float
    flat_power: float
    beta_voc: float
    gamma_pmp: float

    def largest(self) -> float:
        """Return the largest of the deviations, without its sign."""
        return max(abs(value) for value in self)


def fit(panel: Panel) -> SingleDiode:
    """Fit the CEC six-parameter model to a data sheet; where it comes with parameters, return these.

    Where the sheet's rounded numbers leave only a negative shunt, its short-circuit current is raised by 1 % up to
    five times, as SAM does; `deviations` shows it. Dobos 2012, DOI 10.1115/1.4005759.

    Arguments
    ---------
    panel : the data sheet of one panel.

    Returns
    -------
    The parameters of one panel at 1000 W/m2 and 25 degC.

    Raises
    ------
    UserError : no single-diode curve goes through these points with these coefficients.
    """
    if panel.single_diode is not None:
        return SingleDiode(**panel.single_diode.model_dump())
    for raised in _SHORT_CIRCUIT_FACTORS:
        sheet = panel.model_copy(update={"short_circuit_current_a": raised * panel.short_circuit_current_a})
        diode = _solve(sheet)
        if diode is not None and diode.series_resistance_ohm >= 0 and diode.shunt_resistance_ohm > 0:
            return diode
    raise UserError(
        f"panel {panel.title!r}: no single-diode curve with positive resistances goes through its data sheet (I_sc "
        f"{panel.short_circuit_current_a:g} A, V_oc {panel.open_circuit_voltage_v:g} V, I_mp "
        f"{panel.max_power_current_a:g} A, V_mp {panel.max_power_voltage_v:g} V, {panel.cells_in_series} cells in "
        "series); check these values and the temperature coefficients"
    )


def _solve(panel: Panel) -> SingleDiode | None:
    """Return the parameters that meet all six equations, whatever their sign; nothing where there are none.

    The three points of the sheet are linear in photocurrent, saturation current and shunt conductance, which leaves
    ideality, series resistance and adjustment to the solver.
    """
    from scipy.optimize import root

    thermal_v = panel.cells_in_series * BOLTZMANN_EV_PER_K * REFERENCE_TEMPERATURE_K
    drop_v = panel.open_circuit_voltage_v - panel.max_power_voltage_v
    resistance_ohm = 0.37 * drop_v / panel.max_power_current_a

    def diode_of(unknowns: NDArray[np.float64]) -> SingleDiode:
        ideality, share, adjust_percent = map(float, unknowns)
        return _through_points(panel, thermal_v * ideality, resistance_ohm * share, adjust_percent)

    def misses(unknowns: NDArray[np.float64]) -> list[float]:
        try:
            return list(deviations(panel, diode_of(unknowns))[3:])
        except (ValueError, OverflowError, np.linalg.LinAlgError):
            return [1e3, 1e3, 1e3]  # outside the model; the solver turns back

    for ideality, share in itertools.product(_FIRST_IDEALITIES, _FIRST_RESISTANCE_SHARES):
        solution = root(misses, [ideality, share, 0.0], method="hybr", tol=1e-13)
        if max(map(abs, solution.fun)) < _ACCEPTED:
            return diode_of(solution.x)
    return None


def deviations(panel: Panel, diode: SingleDiode) -> Deviations:
    """Return how far each fitted equation is missed, for any parameters.

    Arguments
    ---------
    panel : the data sheet.
    diode : parameters of one panel.

    Returns
    -------
    Relative deviations: of I_sc, of V_oc by way of its current over I_sc, of I_mp at V_mp, of dP/dV = 0 as
    (dP/dV)/I_mp, of beta by way of the current at the hotter V_oc over I_sc, of gamma.
    """
    isc, imp = panel.short_circuit_current_a, panel.max_power_current_a
    resistance = diode.series_resistance_ohm
    knee_v = panel.max_power_voltage_v + imp * resistance
    slope = conductance(diode, knee_v)
    hotter = at_temperature(diode, panel.alpha_isc_a_per_k, REFERENCE_TEMPERATURE_K + _OPEN_CIRCUIT_RISE_K)
    beta = panel.beta_voc_v_per_k * (1.0 + diode.adjust_percent / 100.0)
    powers = [max_power_w(at_temperature(diode, panel.alpha_isc_a_per_k, kelvin)) for kelvin in _POWER_TEMPERATURES_K]
    span_k = _POWER_TEMPERATURES_K[1] - _POWER_TEMPERATURES_K[0]
    gamma = 100.0 * (powers[1] - powers[0]) / span_k / (imp * panel.max_power_voltage_v)
    return Deviations(
        short_circuit=current(diode, isc * resistance) / isc - 1.0,
        open_circuit=current(diode, panel.open_circuit_voltage_v) / isc,
        max_power_point=current(diode, knee_v) / imp - 1.0,
        flat_power=1.0 - panel.max_power_voltage_v / imp * slope / (1.0 + resistance * slope),
        beta_voc=current(hotter, panel.open_circuit_voltage_v + beta * _OPEN_CIRCUIT_RISE_K) / isc,
        gamma_pmp=gamma / panel.gamma_pmp_percent_per_k - 1.0,
    )


def _through_points(panel: Panel, ideality_v: float, resistance_ohm: float, adjust_percent: float) -> SingleDiode:
    # The saturation current is scaled by exp(V_oc/a), so that the three linear equations are well conditioned.
    points = [
        (0.0, panel.short_circuit_current_a),
        (panel.open_circuit_voltage_v, 0.0),
        (panel.max_power_voltage_v, panel.max_power_current_a),
    ]
    rows = []
    for voltage_v, current_a in points:
        diode_v = voltage_v + current_a * resistance_ohm
        open_v = panel.open_circuit_voltage_v
        growth = math.exp((diode_v - open_v) / ideality_v) - math.exp(-open_v / ideality_v)
        rows.append([1.0, -growth, -diode_v])
    photocurrent, scaled, shunt_s = np.linalg.solve(rows, [current_a for _, current_a in points])
    saturation = scaled * math.exp(-panel.open_circuit_voltage_v / ideality_v)
    if not (photocurrent > 0 and saturation > 0 and shunt_s != 0):
        raise ValueError("no diode")
    return SingleDiode(
        float(photocurrent),
        float(saturation),
        float(resistance_ohm),
        float(1.0 / shunt_s),
        float(ideality_v),
        float(adjust_percent),
    )
