"""The fit against its own equations, pvlib's functions, the data sheet and SAM's fit of the same sheet."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import calcparams_cec, calcparams_desoto, max_power_point, singlediode

from pipeline.errors import UserError
from pipeline.panel.equivalent import REFERENCE_TEMPERATURE_K, at_temperature, max_power_w
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, deviations, fit

# SAM's own six-parameter solver (NREL-PySAM, through pvlib.ivtools.sdm.fit_cec_sam) on the same sheet.
SAM = SingleDiode(3.991839, 3.456264e-10, 0.425523, 923.363, 0.936798, 2.684)

NAMES = (
    "max_power_w", "max_power_voltage_v", "max_power_current_a", "open_circuit_voltage_v", "short_circuit_current_a",
    "alpha_isc_a_per_k", "beta_voc_v_per_k", "gamma_pmp_percent_per_k", "cells_in_series",
)  # fmt: skip
OTHERS = {
    "54 cells, poly": (200.0, 26.3, 7.61, 32.9, 8.21, 3.18e-3, -0.123, -0.47, 54),
    "60 cells, mono": (300.0, 32.6, 9.21, 39.9, 9.77, 4.9e-3, -0.116, -0.39, 60),
}


def test_every_equation_is_met(kc65t, diode):
    assert deviations(kc65t, diode).largest() < 1e-9


def test_deviations_see_a_wrong_parameter(kc65t, diode):
    for name in diode._fields:
        wrong = diode._replace(**{name: 1.02 * getattr(diode, name)})
        assert deviations(kc65t, wrong).largest() > 1e-6, name


def test_table_1_is_met_to_a_thousandth_in_pvlib(kc65t, diode):
    found = singlediode(
        diode.photocurrent_a,
        diode.saturation_current_a,
        diode.series_resistance_ohm,
        diode.shunt_resistance_ohm,
        diode.modified_ideality_v,
    )
    printed = {"i_sc": 3.99, "v_oc": 21.7, "i_mp": 3.75, "v_mp": 17.4}
    for name, value in printed.items():
        assert float(found[name]) == pytest.approx(value, rel=1e-3), name
    assert float(found["p_mp"]) == pytest.approx(65.25, rel=1e-6)
    assert kc65t.max_power_w == pytest.approx(float(found["p_mp"]), rel=5e-3)  # the print rounds to 65 W


def test_parameters_agree_with_sams_solver(diode):
    # SAM stops its iterations at 1e-3 or so: the shunt, the least certain of the six, differs by half a percent.
    bounds = SingleDiode(1e-5, 2e-2, 1e-3, 1e-2, 1e-3, 1e-2)
    for name in diode._fields:
        assert getattr(diode, name) == pytest.approx(getattr(SAM, name), rel=getattr(bounds, name)), name
    ideality = diode.modified_ideality_v / (36 * 8.617333262e-5 * 298.15)
    assert ideality == pytest.approx(1.0128, rel=1e-3)


@pytest.mark.parametrize("temperature_c", np.linspace(-10.0, 75.0, 8))
def test_parameters_follow_temperature_as_in_pvlib(kc65t, diode, temperature_c):
    ours = at_temperature(diode, kc65t.alpha_isc_a_per_k, temperature_c + 273.15)
    theirs = calcparams_cec(
        1000.0, temperature_c, kc65t.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
        diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm, diode.adjust_percent,
    )  # fmt: skip
    photocurrent, saturation, series, shunt, ideality = (float(value) for value in theirs)
    assert ours[:5] == pytest.approx((photocurrent, saturation, series, shunt, ideality), rel=1e-6)
    assert max_power_w(ours) == pytest.approx(
        float(max_power_point(photocurrent, saturation, series, shunt, ideality, method="brentq")["p_mp"]), rel=1e-6
    )


def test_without_adjustment_the_model_is_de_sotos(kc65t, diode):
    ours = at_temperature(diode._replace(adjust_percent=0.0), kc65t.alpha_isc_a_per_k, 323.15)
    theirs = calcparams_desoto(
        1000.0, 50.0, kc65t.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
        diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm,
    )  # fmt: skip
    assert ours[:5] == pytest.approx(tuple(float(value) for value in theirs), rel=1e-6)


@pytest.mark.parametrize("name", OTHERS)
def test_other_data_sheets_are_fitted(name):
    panel = Panel(title=name, **dict(zip(NAMES, OTHERS[name], strict=True)))
    found = fit(panel)
    assert deviations(panel, found).largest() < 1e-8
    assert 0.9 < found.modified_ideality_v / (panel.cells_in_series * 8.617333262e-5 * REFERENCE_TEMPERATURE_K) < 1.6


def test_parameters_are_found_again_from_a_made_up_panel(kc65t):
    made, alpha = SingleDiode(5.1, 2.0e-9, 0.30, 250.0, 1.05, 5.0), 0.003
    point = {name: float(value) for name, value in singlediode(*made[:5]).items()}
    hot = singlediode(*at_temperature(made, alpha, 303.15)[:5])
    powers = [max_power_w(at_temperature(made, alpha, kelvin)) for kelvin in (263.15, 323.15)]
    found = kc65t.model_copy(
        update={
            "max_power_voltage_v": point["v_mp"],
            "max_power_current_a": point["i_mp"],
            "open_circuit_voltage_v": point["v_oc"],
            "short_circuit_current_a": point["i_sc"],
            "alpha_isc_a_per_k": alpha,
            "beta_voc_v_per_k": (float(hot["v_oc"]) - point["v_oc"]) / 5.0 / 1.05,
            "gamma_pmp_percent_per_k": (powers[1] - powers[0]) / 60.0 / point["p_mp"] * 100.0,
        }
    )
    assert fit(found) == pytest.approx(made, rel=5e-3)


def test_a_sheet_no_diode_can_follow_ends_in_a_clear_error(kc65t):
    square = kc65t.model_copy(update={"max_power_voltage_v": 21.5, "max_power_current_a": 3.98, "max_power_w": 85.57})
    with pytest.raises(UserError, match=r"Kyocera KC65T.*(no single-diode curve|negative resistance)"):
        fit(square)
