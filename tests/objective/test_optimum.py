from __future__ import annotations

import numpy as np
import pytest

from pipeline.objective.optimum import (
    band_hz,
    contour_energy_j,
    energy_for_optimum_j,
    error_mw,
    frequency_map_hz,
    integral_square_error,
    objective,
    optimal_frequency_hz,
    steps,
    switched_currents_a,
    switching_energy_j,
    with_capacitance,
)
from pipeline.objective.records import Pairs, Waveform
from pipeline.search.algorithms import sweep

ENERGY = 3.757e-6
OTHERS = {
    "reflex, two pairs": (Waveform(charge_a=2.1, charge_share=0.9, discharge_a=0.5, discharge_share=0.05), 3.757e-6),
    "deep discharge": (Waveform(charge_a=2.1, charge_share=0.7, discharge_a=4.0, discharge_share=0.1), 2e-5),
    "pulse": (Waveform(charge_a=2.33, charge_share=0.8), 3.757e-6),
    "no rest": (Waveform(charge_a=1.0, charge_share=0.95, discharge_a=1.0, discharge_share=0.05), 1e-6),
}


def test_the_calibrated_values_give_the_published_numbers(reflex, pairs, settings):
    energy = switching_energy_j(settings.transistor, switched_currents_a(reflex))
    period = steps(reflex)
    best = float(optimal_frequency_hz(period, pairs, energy))
    assert best == pytest.approx(90.0, abs=0.05)
    ise = float(integral_square_error(error_mw(period, pairs, energy, best), settings.window_s))
    assert ise == pytest.approx(0.200, abs=5e-4)


def test_the_minimum_is_flat(reflex, pairs):
    low, high = band_hz(steps(reflex), pairs, ENERGY, 0.01)
    assert (round(low), round(high)) == (84, 97)
    low, high = band_hz(steps(reflex), pairs, ENERGY, 0.10)
    assert (round(low), round(high)) == (72, 114)
    evaluate = objective(steps(reflex), pairs, ENERGY, 1.0)
    least = float(evaluate(np.array([[optimal_frequency_hz(steps(reflex), pairs, ENERGY)]]))[0])
    np.testing.assert_allclose(evaluate(np.array([[low], [high]])), 1.1 * least, rtol=1e-9)


@pytest.mark.parametrize("name", OTHERS)
def test_brute_force_finds_the_stationary_point(name, pairs):
    waveform, energy = OTHERS[name]
    settings = sweep.Settings(title="sweep", variables={"f": {"low": 1.0, "high": 500.0}}, points=4991, refinements=2)
    found = sweep.minimise(objective(steps(waveform), pairs, energy, 0.745), settings.box(), settings)
    exact = float(optimal_frequency_hz(steps(waveform), pairs, energy))
    assert 1.0 < exact < 500.0
    assert found.best_position()[0, 0] == pytest.approx(exact, abs=2e-3)
    assert abs(found.position[0, 0, 0] - exact) <= 0.1


def test_optimum_moves_with_energy_and_capacitance(reflex, pairs):
    period = steps(reflex)
    found = optimal_frequency_hz(period, pairs, ENERGY * np.array([0.5, 2.0, 0.1, 10.0]))
    np.testing.assert_allclose(found, [115, 70, 200, 35], atol=0.6)
    for capacitance, expected in ((0.2, 139), (0.8, 58)):
        moved = optimal_frequency_hz(period, with_capacitance(pairs, 0, capacitance), ENERGY)
        assert float(moved) == pytest.approx(expected, abs=0.6)


def test_fast_pair_alone_follows_the_cube_root_law(reflex):
    # Far above the pair's corner the ripple loss falls with the square of the frequency.
    period, pair = steps(reflex), Pairs((0.015,), (0.006,))
    energies = np.array([1e-11, 1e-12])
    first, second = optimal_frequency_hz(period, pair, energies)
    assert second / first == pytest.approx(10.0 ** (1.0 / 3.0), rel=1e-3)


def test_energy_for_an_optimum_is_the_inverse(reflex, pairs):
    period = steps(reflex)
    frequencies = np.array([10.0, 50.0, 90.0, 250.0])
    energies = energy_for_optimum_j(period, pairs, frequencies)
    assert energies[2] == pytest.approx(3.756e-6, abs=1e-9)
    np.testing.assert_allclose(optimal_frequency_hz(period, pairs, energies), frequencies, rtol=1e-9)


def test_map_and_its_contour_agree(reflex, pairs):
    period = steps(reflex)
    capacitances = np.array([0.2, 0.4, 0.8])
    contour = contour_energy_j(period, pairs, 0, capacitances, 90.0)
    whole = frequency_map_hz(period, pairs, 0, capacitances, contour)
    assert whole.shape == (3, 3)
    np.testing.assert_allclose(np.diag(whole), 90.0, rtol=1e-9)
    assert np.all(np.diff(whole, axis=0) < 0.0), "a larger capacitance needs a lower frequency"


def test_no_optimum_is_no_number(reflex, pairs):
    assert np.isnan(optimal_frequency_hz(steps(reflex), pairs, 1.0))
