from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from pipeline.experiments.frequency.objective import quantities
from pipeline.objective.optimum import (
    breakdown,
    discharge_resistor_loss_w,
    error_mw,
    frequency_loss_w,
    impedance_minimum_hz,
    impedance_ohm,
    integral_square_error,
    mean_current_a,
    objective,
    resonance_hz,
    ripple_square_a2,
    steps,
    switching_energy_j,
)
from pipeline.objective.records import Transistor, Waveform

ENERGY = 3.757e-6
FREQUENCIES = [1, 10, 30, 50, 70, 90, 120, 200, 500, 1000]


def test_switching_energy_adds_edges_capacitance_and_gate():
    transistor = Transistor(
        rise_time_s=40e-9, fall_time_s=60e-9, output_capacitance_f=500e-12, gate_charge_c=40e-9, gate_voltage_v=10.0,
        blocked_voltage_v=14.4,
    )  # fmt: skip
    assert switching_energy_j(transistor, ()) == 0.0
    # 1/2 14.4 V 2.1 A 100 ns + 1/2 500 pF (14.4 V)^2 + 40 nC 10 V
    assert switching_energy_j(transistor, (2.1,)) == pytest.approx(1.512e-6 + 51.84e-9 + 400e-9, rel=1e-12)
    both = switching_energy_j(transistor, (2.1, 0.5))
    assert both == pytest.approx(1.872e-6 + 2 * (51.84e-9 + 400e-9), rel=1e-12)


def test_parts_of_the_loss_over_frequency(reflex, pairs):
    parts = breakdown(steps(reflex), pairs, 0.025, ENERGY, FREQUENCIES)
    ripple = 1e3 * (parts["series_ripple_w"] + parts["pair_ripple_w"])
    expected = [19.91, 16.02, 13.70, 13.10, 12.87, 12.76, 12.69, 12.62, 12.59, 12.58]
    assert np.round(ripple, 2).tolist() == expected
    switching = [0.004, 0.038, 0.113, 0.188, 0.263, 0.338, 0.451, 0.751, 1.879, 3.757]
    np.testing.assert_allclose(1e3 * parts["switching_w"], switching, atol=5.1e-4)
    total = [19.92, 16.06, 13.81, 13.28, 13.13, 13.10, 13.14, 13.37, 14.47, 16.34]
    assert np.round(1e3 * parts["total_w"], 2).tolist() == total
    assert parts["mean_current_w"] == pytest.approx(1.865**2 * 0.070, rel=1e-12)


def test_error_is_independent_of_the_series_resistance(reflex, pairs):
    period = steps(reflex)
    for series in (0.0, 0.025, 0.1):
        least = ripple_square_a2(period) * series
        total = breakdown(period, pairs, series, ENERGY, FREQUENCIES)["total_w"]
        np.testing.assert_allclose(error_mw(period, pairs, ENERGY, FREQUENCIES), 1e3 * (least - total), rtol=1e-9)


def test_integral_square_error_over_frequency(reflex, pairs):
    expected = {
        0.954: "40.6", 1: "40.1", 10: "9.01", 30: "1.133", 50: "0.368", 70: "0.2248", 80: "0.2052", 90: "0.2001",
        100: "0.2040", 120: "0.2294", 200: "0.465", 1000: "10.5",
    }  # fmt: skip
    for frequency, digits in expected.items():
        found = float(integral_square_error(error_mw(steps(reflex), pairs, ENERGY, frequency), 0.745))
        assert f"{found:.{len(digits.split('.')[1])}f}" == digits, frequency


def test_objective_takes_the_whole_population_at_once(reflex, pairs):
    evaluate = objective(steps(reflex), pairs, ENERGY, 0.745)
    population = np.linspace(1.0, 500.0, 50)[:, None]
    together = evaluate(population)
    assert together.shape == (50,)
    one_by_one = [float(evaluate(particle[None, :])[0]) for particle in population]
    np.testing.assert_allclose(together, one_by_one, rtol=1e-12)


def test_a_pulse_of_the_same_share_has_less_ripple_and_one_of_the_same_mean_more(reflex, pairs):
    def ripple_mw(waveform):
        period = steps(waveform)
        loss = frequency_loss_w(period, pairs, 0.0, 90.0) + 0.025 * ripple_square_a2(period)
        return 1e3 * float(loss)

    same_mean, same_share = Waveform(charge_a=2.33, charge_share=0.8), Waveform(charge_a=2.1, charge_share=0.9)
    assert mean_current_a(steps(same_mean)) == pytest.approx(mean_current_a(steps(reflex)), rel=1e-3)
    assert ripple_mw(same_mean) == pytest.approx(22.3, abs=0.05)
    assert ripple_mw(reflex) == pytest.approx(12.8, abs=0.05)
    assert ripple_mw(same_share) == pytest.approx(10.1, abs=0.05)


def test_the_resistor_takes_a_thousand_times_what_the_frequency_decides(reflex, pairs, settings):
    assert discharge_resistor_loss_w(reflex, 13.5) == pytest.approx(0.3375, rel=1e-12)
    found = {quantity.name: quantity.value for quantity in quantities(settings, reflex, pairs, 0.025)}
    assert found["discharge_resistor_w"] / found["switching_at_optimum_w"] == pytest.approx(998, rel=0.01)


@pytest.mark.parametrize(
    ("circuit", "least", "real"),
    [((1e-7, 0.025, 0.015, 0.4), 1148.0, 795.0), ((1e-6, 0.025, 0.030, 3.0), 117.4, 91.87)],
)
def test_least_impedance_is_where_a_numerical_search_finds_it(circuit, least, real):
    inductance, _, resistance, capacitance = circuit
    found = impedance_minimum_hz(*circuit)
    assert found == pytest.approx(least, rel=1e-3)
    numerical = minimize_scalar(
        lambda f: abs(impedance_ohm(f, *circuit)), bounds=(0.1 * least, 10 * least), options={"xatol": 1e-7}
    )
    assert found == pytest.approx(numerical.x, rel=1e-5)
    assert resonance_hz(inductance, resistance, capacitance) == pytest.approx(real, rel=1e-3)
    assert impedance_ohm(resonance_hz(inductance, resistance, capacitance), *circuit).imag == pytest.approx(
        0, abs=1e-12
    )


def test_large_inductance_leaves_no_minimum():
    assert impedance_minimum_hz(1.0, 0.025, 0.015, 0.4) == 0.0
    assert resonance_hz(1.0, 0.015, 0.4) == 0.0


def test_summary_names_every_quantity_once(settings, reflex, pairs):
    found = quantities(settings, reflex, pairs, 0.025)
    assert len({quantity.name for quantity in found}) == len(found)
    values = {quantity.name: quantity.value for quantity in found}
    saved = values["ripple_and_switching_at_classic_w"] - values["ripple_and_switching_at_optimum_w"]
    assert 1e3 * saved == pytest.approx(6.87, abs=0.01)
    assert values["impedance_minimum_hz"] > 10 * values["optimal_frequency_hz"]
    assert values["ise_at_impedance_minimum"] > values["ise_at_optimum"]
