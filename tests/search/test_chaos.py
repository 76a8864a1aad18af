"""The logistic map against its exact invariants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import arcsine as arcsine_law
from scipy.stats import kstest

from pipeline.search.chaos import (
    ESCAPE,
    arcsine,
    arcsine_cumulative,
    arcsine_entropy,
    guarded,
    logistic,
    orbit,
)
from pipeline.search.disorder import disorder

ENTROPY = {
    2: 0.693147, 8: 1.973156, 10: 2.182802, 16: 2.628222, 20: 2.841377, 32: 3.293438, 50: 3.726025, 64: 3.966486,
    100: 4.402994, 200: 5.084638, 256: 5.328267, 1000: 6.678674,
}  # fmt: skip


def test_orbit_is_the_conjugate_of_angle_doubling():
    # x = sin^2(t) maps to sin^2(2 t): exact until rounding has doubled to where it shows.
    start = 0.3
    expected = np.sin(2.0 ** np.arange(20) * np.arcsin(np.sqrt(start))) ** 2
    np.testing.assert_allclose(orbit(start, 20), expected, atol=1e-9)


def test_orbits_of_many_starts_and_parameters_run_together():
    starts, parameters = np.array([[0.1], [0.2]]), np.array([3.5, 3.7, 4.0])
    together = orbit(starts, 7, parameters, transient=3)
    assert together.shape == (7, 2, 3)
    np.testing.assert_array_equal(together[:, 1, 2], orbit(0.2, 7, 4.0, transient=3))
    np.testing.assert_array_equal(orbit(0.2, 9)[3:], orbit(0.2, 6, transient=3))


def test_density_at_full_chaos_is_the_arcsine_law_and_not_uniform():
    values = orbit(np.random.default_rng(1).random(2000), 1, transient=50)[0]
    assert kstest(values, arcsine_law.cdf).pvalue > 0.01
    assert kstest(values, "uniform").pvalue < 1e-10
    x = np.linspace(0.0, 1.0, 11)
    np.testing.assert_allclose(arcsine_cumulative(x), arcsine_law.cdf(x), atol=1e-12)


def test_moments_at_full_chaos():
    values = orbit(np.random.default_rng(2).random(1000), 1000, transient=10)
    assert np.mean(values) == pytest.approx(1 / 2, abs=2e-3)
    assert np.var(values) == pytest.approx(1 / 8, abs=1e-3)
    assert np.mean(values**3) == pytest.approx(5 / 16, abs=2e-3)
    assert np.mean(values < 0.1) == pytest.approx(0.2048, abs=2e-3)
    assert np.mean((values - 0.5)[1:] * (values - 0.5)[:-1]) == pytest.approx(0.0, abs=1e-3)


def test_arcsine_numbers_have_the_maps_density_without_its_order():
    values = arcsine(np.random.default_rng(3).random(5000))
    assert kstest(values, arcsine_law.cdf).pvalue > 0.01
    assert np.max(np.abs(logistic(values[:-1]) - values[1:])) > 0.5


@pytest.mark.parametrize("bins", ENTROPY)
def test_exact_entropy(bins):
    assert arcsine_entropy(bins) == pytest.approx(ENTROPY[bins], abs=5.1e-7)


def test_entropy_tends_to_that_of_the_density():
    assert arcsine_entropy(1_000_000) - np.log(1_000_000) == pytest.approx(np.log(np.pi / 4), abs=1e-3)


def test_measured_entropy_and_exponent_at_full_chaos():
    found = disorder(4.0, bins=100, steps=1_000_000)
    assert found.lyapunov[0] == pytest.approx(np.log(2.0), abs=1e-4)
    assert found.entropy[0] == pytest.approx(arcsine_entropy(100), abs=2e-3)


@pytest.mark.parametrize(("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.83, 3)])
def test_entropy_in_a_periodic_window_is_the_logarithm_of_the_period(r, period):
    found = disorder(r, bins=100)
    assert found.entropy[0] == pytest.approx(np.log(period), abs=1e-6)
    assert found.lyapunov[0] < 0.0


def test_exponent_of_a_stable_cycle_is_the_logarithm_of_its_multiplier():
    # r = 3.2: the two points of the cycle are known, (r + 1 +- sqrt((r - 3) (r + 1))) / 2 r.
    r = 3.2
    cycle = (r + 1 + np.array([1, -1]) * np.sqrt((r - 3) * (r + 1))) / (2 * r)
    expected = np.mean(np.log(np.abs(r * (1 - 2 * cycle))))
    assert expected == pytest.approx(-0.9163, abs=5e-5)
    assert disorder(r, bins=10).lyapunov[0] == pytest.approx(expected, abs=1e-6)


def test_exponents_at_other_parameters():
    np.testing.assert_allclose(disorder([3.5, 3.83, 3.9], bins=10).lyapunov, [-0.8725, -0.37, 0.4975], atol=5e-3)


def test_the_two_measures_disagree_on_the_greatest_disorder():
    r = np.arange(3.9, 4.0005, 0.001)
    found = disorder(r, bins=100)
    assert r[np.argmax(found.lyapunov)] == pytest.approx(4.0, abs=1e-9)
    most = r[np.argmax(found.entropy)]
    assert 3.975 < most < 3.995
    assert found.entropy.max() - found.entropy[-1] > 0.04


@pytest.mark.parametrize("start", [0.0, 0.25, 0.5, 0.75, 1.0])
def test_starts_that_end_in_a_fixed_point_are_replaced(start):
    assert np.ptp(orbit(start, 4, transient=3)) == 0.0, "the orbit stands still"
    assert guarded(start) == ESCAPE
    assert np.ptp(orbit(guarded(start), 100)) > 0.9


def test_other_starts_are_left_alone():
    starts = np.random.default_rng(4).random(1000)
    np.testing.assert_array_equal(guarded(starts), starts)


@pytest.mark.parametrize("angle", [1 / 8, 3 / 8, 1 / 12, 5 / 12])
def test_preimages_cannot_trap_a_guarded_orbit(angle):
    x = np.sin(np.pi * angle) ** 2
    values = []
    for _ in range(200):
        x = guarded(x)
        values.append(float(x))
        x = logistic(x)
    assert np.ptp(values[-100:]) > 0.9
