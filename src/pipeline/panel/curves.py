"""Characteristic points and curves of the fitted panel over irradiance and temperature; curves by pvlib."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.panel.maximum_power import characteristic_points
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, Panel, PanelCurveSettings, Weather
from pipeline.panel.single_diode import SingleDiode, deviations

Columns = dict[str, NDArray[np.float64]]


def parameters(panel: Panel, diode: SingleDiode) -> Columns:
    """Return the fitted parameters and the fit's largest relative deviation, as the one row of PANEL_PARAMETERS."""
    columns = {name: np.array([value]) for name, value in diode._asdict().items()}
    columns["fit_residual"] = np.array([deviations(panel, diode).largest()])
    return columns


def points(panel: Panel, diode: SingleDiode, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> Columns:
    """Return the characteristic points of all panels together.

    Arguments
    ---------
    panel : the data sheet; its temperature coefficients and the number of panels.
    diode : fitted parameters of one panel.
    irradiance_w_m2, cell_temperature_c : one row per condition [W/m2], [degC], shape (n,).

    Returns
    -------
    The columns of PANEL_POINTS, shape (n,) each.
    """
    irradiance, temperature = _rows(irradiance_w_m2, cell_temperature_c)
    found = characteristic_points(panel, diode, irradiance, temperature)._asdict()
    for name in ("short_circuit_current_a", "max_power_current_a", "max_power_w"):
        found[name] = found[name] * panel.panels_in_parallel
    for name in ("open_circuit_voltage_v", "max_power_voltage_v", "max_power_w"):
        found[name] = found[name] * panel.panels_in_series
    return {"irradiance_w_m2": irradiance, "cell_temperature_c": temperature, **found}


def curves(panel: Panel, diode: SingleDiode, settings: PanelCurveSettings) -> tuple[Columns, Columns]:
    """Return the current-voltage curves over the whole grid of irradiances and temperatures.

    Arguments
    ---------
    panel : the data sheet.
    diode : fitted parameters of one panel.
    settings : the grid.

    Returns
    -------
    The columns of PANEL_CURVES, from short circuit to open circuit, a curve after the other, and of PANEL_POINTS.
    """
    from pvlib.pvsystem import i_from_v

    grid = np.array(list(itertools.product(settings.irradiances_w_m2, settings.cell_temperatures_c)))
    ends = points(panel, diode, grid[:, 0], grid[:, 1])
    photocurrent, saturation, series, shunt, ideality = _conditions(panel, diode, grid[:, 0], grid[:, 1])
    shares = np.linspace(0.0, 1.0, settings.points_per_curve)
    voltage = ends["open_circuit_voltage_v"][:, None] * shares
    current = panel.panels_in_parallel * i_from_v(
        voltage / panel.panels_in_series,
        photocurrent[:, None],
        saturation[:, None],
        series,
        shunt[:, None],
        ideality[:, None],
        method="newton",
    )
    current[:, -1] = 0.0  # what open circuit means; the solver leaves some 1e-12 A
    columns = {
        "irradiance_w_m2": np.repeat(grid[:, 0], settings.points_per_curve),
        "cell_temperature_c": np.repeat(grid[:, 1], settings.points_per_curve),
        "voltage_v": voltage.ravel(),
        "current_a": current.ravel(),
        "power_w": (voltage * current).ravel(),
    }
    return columns, ends


def _rows(irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    irradiance, temperature = np.broadcast_arrays(
        np.atleast_1d(np.asarray(irradiance_w_m2, dtype=float)),
        np.atleast_1d(np.asarray(cell_temperature_c, dtype=float)),
    )
    return irradiance.copy(), temperature.copy()


def _conditions(
    panel: Panel, diode: SingleDiode, irradiance: NDArray[np.float64], temperature: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, NDArray[np.float64], NDArray[np.float64]]:
    from pvlib.pvsystem import calcparams_cec

    photocurrent, saturation, series, shunt, ideality = calcparams_cec(
        irradiance,
        temperature,
        panel.alpha_isc_a_per_k,
        diode.modified_ideality_v,
        diode.photocurrent_a,
        diode.saturation_current_a,
        diode.shunt_resistance_ohm,
        diode.series_resistance_ohm,
        diode.adjust_percent,
    )
    shunt = np.broadcast_to(shunt, irradiance.shape)
    return photocurrent, saturation, float(np.ravel(series)[0]), shunt, ideality


_TEMPERATURES_C = (25.0, 30.0, -10.0, 50.0)
"""Reference; the step over which both coefficients at the axes are taken; the span of that of the maximum power."""


def agreement(panel: Panel, diode: SingleDiode) -> dict[str, list[Any]]:
    """Return the values of the data sheet beside those of the model.

    Arguments
    ---------
    panel : the data sheet.
    diode : single-diode parameters of one panel.

    Returns
    -------
    The columns of PANEL_FIT; the coefficients of the model are taken as in the fit, with its adjustment.
    """
    found = characteristic_points(panel, diode, REFERENCE_IRRADIANCE_W_M2, np.array(_TEMPERATURES_C))
    rise, span = _TEMPERATURES_C[1] - _TEMPERATURES_C[0], _TEMPERATURES_C[3] - _TEMPERATURES_C[2]
    power = found.max_power_w
    rows = [
        ("maximum power", "W", panel.max_power_w, power[0]),
        ("voltage at maximum power", "V", panel.max_power_voltage_v, found.max_power_voltage_v[0]),
        ("current at maximum power", "A", panel.max_power_current_a, found.max_power_current_a[0]),
        ("open-circuit voltage", "V", panel.open_circuit_voltage_v, found.open_circuit_voltage_v[0]),
        ("short-circuit current", "A", panel.short_circuit_current_a, found.short_circuit_current_a[0]),
        ("coefficient of I_sc", "A/K", panel.alpha_isc_a_per_k, _slope(found.short_circuit_current_a, rise)),
        ("coefficient of V_oc", "V/K", panel.beta_voc_v_per_k, _slope(found.open_circuit_voltage_v, rise)),
        (
            *("coefficient of the maximum power", "%/K", panel.gamma_pmp_percent_per_k),
            100.0 * (power[3] - power[2]) / span / power[0],
        ),
    ]
    return {
        "quantity": [name for name, *_ in rows],
        "unit": [unit for _, unit, *_ in rows],
        "data_sheet": [float(sheet) for *_, sheet, _ in rows],
        "model": [float(model) for *_, model in rows],
    }


def _slope(values: np.ndarray, rise_k: float) -> float:
    return float(values[1] - values[0]) / rise_k


class Conditions(NamedTuple):
    """Irradiance and cell temperature, each constant from its time to the next."""

    time_s: NDArray[np.float64]
    irradiance_w_m2: NDArray[np.float64]
    cell_temperature_c: NDArray[np.float64]


def conditions(weather: Weather) -> Conditions:
    """Return the weather as columns.

    Arguments
    ---------
    weather : the record.

    Returns
    -------
    Columns of one length; a single row for constant weather.
    """
    return Conditions(np.array([0.0]), np.array([weather.irradiance_w_m2]), np.array([weather.cell_temperature_c]))
