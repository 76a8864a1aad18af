"""Curves and points: shape, temperature coefficients, pvlib and the Sandia model of the same panel."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import calcparams_cec, i_from_v, retrieve_sam, sapm, singlediode
from tests.making import declared

from pipeline.kernel import tables
from pipeline.panel.curves import curves, parameters, points
from pipeline.panel.records import PanelCurveSettings

SETTINGS = PanelCurveSettings(points_per_curve=61)
GRID = [(g, t) for g in (50.0, 200.0, 400.0, 600.0, 800.0, 1000.0) for t in (-10.0, 10.0, 25.0, 50.0, 75.0)]


@pytest.fixture(scope="module")
def grid(kc65t, diode):
    return curves(kc65t, diode, SETTINGS)


def by_curve(columns, name):
    return columns[name].reshape(-1, SETTINGS.points_per_curve)


def test_tables_are_as_declared(kc65t, diode, grid, tmp_path):
    made = {
        declared("panel")["curves"].table: grid[0],
        declared("panel")["points"].table: grid[1],
        declared("panel")["parameters"].table: parameters(kc65t, diode),
    }
    for table, columns in made.items():
        tables.write(table, columns, tmp_path / table.name)
        assert set(tables.read(table, tmp_path / table.name)) == set(columns)


def test_current_falls_along_every_curve_from_short_to_open_circuit(grid):
    current, voltage = by_curve(grid[0], "current_a"), by_curve(grid[0], "voltage_v")
    assert np.all(np.diff(current, axis=1) < 0)
    assert np.all(np.diff(voltage, axis=1) > 0)
    np.testing.assert_allclose(current[:, 0], grid[1]["short_circuit_current_a"], rtol=1e-9)
    np.testing.assert_allclose(voltage[:, -1], grid[1]["open_circuit_voltage_v"], rtol=1e-12)


def test_power_has_one_peak_and_stays_below_the_maximum_power(grid):
    power = by_curve(grid[0], "power_w")
    ratio = power.max(axis=1) / grid[1]["max_power_w"]
    assert np.all(ratio <= 1.0 + 1e-9)
    assert np.all(ratio > 0.995)
    assert np.all(np.sum(np.diff(np.sign(np.diff(power, axis=1)), axis=1) != 0, axis=1) == 1)


@pytest.mark.parametrize(("irradiance", "temperature"), GRID)
def test_every_condition_agrees_with_pvlibs_bracketed_solver(kc65t, diode, irradiance, temperature):
    circuit = calcparams_cec(
        irradiance, temperature, kc65t.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
        diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm, diode.adjust_percent,
    )  # fmt: skip
    expected = singlediode(*circuit, method="brentq")
    found = points(kc65t, diode, irradiance, temperature)
    for ours, theirs in (
        ("short_circuit_current_a", "i_sc"),
        ("open_circuit_voltage_v", "v_oc"),
        ("max_power_w", "p_mp"),
    ):
        assert found[ours][0] == pytest.approx(float(expected[theirs]), rel=1e-7), ours
    # At the reported point of maximum power the current is the one of the circuit, and both neighbours give less.
    voltage = found["max_power_voltage_v"][0] * np.array([0.999, 1.0, 1.001])
    current = np.array([float(i_from_v(v, *circuit, method="lambertw")) for v in voltage])
    assert found["max_power_current_a"][0] == pytest.approx(current[1], rel=1e-7)
    assert np.all((voltage * current)[[0, 2]] < found["max_power_w"][0])


def test_temperature_coefficients_are_the_data_sheets(kc65t, diode):
    cold, warm = points(kc65t, diode, 1000.0, [25.0, 30.0])["short_circuit_current_a"]
    adjust = diode.adjust_percent / 100.0
    assert (warm - cold) / 5.0 == pytest.approx(kc65t.alpha_isc_a_per_k, rel=1.1 * adjust)
    cold, warm = points(kc65t, diode, 1000.0, [25.0, 30.0])["open_circuit_voltage_v"]
    assert (warm - cold) / 5.0 == pytest.approx(kc65t.beta_voc_v_per_k, rel=1.1 * adjust)
    assert (warm - cold) / 5.0 == pytest.approx(kc65t.beta_voc_v_per_k * (1.0 + adjust), rel=1e-4)
    cold, warm = points(kc65t, diode, 1000.0, [-10.0, 50.0])["max_power_w"]
    assert (warm - cold) / 60.0 / 65.25 * 100.0 == pytest.approx(kc65t.gamma_pmp_percent_per_k, rel=1e-4)


@pytest.mark.parametrize(
    ("irradiance", "temperature", "bound"),
    [(1000, 25, 1e-4), (1000, 50, 0.002), (800, 47, 0.004), (600, 25, 0.011), (400, 25, 0.02), (200, 25, 0.05)],
)
def test_maximum_power_agrees_with_the_sandia_model_of_the_same_panel(kc65t, diode, irradiance, temperature, bound):
    module = retrieve_sam("SandiaMod")["Kyocera_Solar_KC65T__2008__E__"]
    expected = sapm(irradiance, temperature, module)["p_mp"]
    assert points(kc65t, diode, irradiance, temperature)["max_power_w"][0] == pytest.approx(expected, rel=bound)


def test_panels_in_series_add_voltage_and_in_parallel_current(kc65t, diode):
    several = kc65t.model_copy(update={"panels_in_series": 2, "panels_in_parallel": 3})
    one_curves, one = curves(kc65t, diode, SETTINGS)
    all_curves, all_ = curves(several, diode, SETTINGS)
    np.testing.assert_allclose(all_["open_circuit_voltage_v"], 2 * one["open_circuit_voltage_v"], rtol=1e-12)
    np.testing.assert_allclose(all_["max_power_w"], 6 * one["max_power_w"], rtol=1e-12)
    np.testing.assert_allclose(all_curves["current_a"], 3 * one_curves["current_a"], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(all_curves["power_w"], 6 * one_curves["power_w"], rtol=1e-9, atol=1e-12)
