"""How well the single-diode model meets the data sheet it was fitted to, or that stands beside it in a database."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.panel.maximum_power import characteristic_points
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, Panel
from pipeline.panel.single_diode import SingleDiode

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
