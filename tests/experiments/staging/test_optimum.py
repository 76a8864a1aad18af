"""The best stage currents: a case that is solved by hand, other solvers, and what the local one must keep to."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import differential_evolution

from pipeline.experiments.staging.front import evolved, gains, scanned
from pipeline.experiments.staging.optimum import best_weighted, convex_share, coolest, fastest
from pipeline.experiments.staging.records import READINGS, FrontSettings, Weights
from pipeline.experiments.staging.stage_charges import Limits, charge, objective_of
from pipeline.experiments.staging.summary import best_cases, constants, starts_of
from tests.experiments.staging.staged import CURRENTS, LIMITS, PRINTED, problem, shipped, simple

EVEN = Weights(time=5.0, rise=5.0)


@pytest.mark.parametrize("reading", READINGS)
def test_constant_resistance_without_cooling_asks_for_equal_currents(reading):
    # Rise R q sum(I) / C, time q sum(1/I): at a given sum of the currents equal ones are fastest.
    asked = problem(simple(), reading)
    found = fastest(asked, 5.0, starts_of(asked, 3, 1))
    current = 5.0 * 270.0 / (0.005 * 2880.0 * 8)
    np.testing.assert_allclose(found.currents_a, current, rtol=1e-4)
    assert found.value == pytest.approx(8 * 2880.0 / current, rel=1e-8)
    assert found.agreeing == 1.0
    cool = coolest(asked, 8 * 2880.0 / current, starts_of(asked, 3, 2))
    assert cool.value == pytest.approx(5.0, rel=1e-7)


@pytest.mark.parametrize("reading", READINGS)
def test_no_evolutionary_search_does_better(reading):
    asked = problem(shipped("lfp_8ah"), reading)
    found = best_weighted(asked, EVEN, starts_of(asked, 4, 3))
    objective = objective_of(asked.grid, CURRENTS, EVEN, reading, LIMITS)
    assert objective(found.currents_a[None, :])[0] == pytest.approx(found.value, rel=1e-12)
    evolution = differential_evolution(
        lambda x: objective(x.T),
        [(CURRENTS.low, CURRENTS.high)] * 8,
        vectorized=True,
        updating="deferred",
        maxiter=150,
        popsize=6,
        rng=np.random.default_rng(1),
        polish=False,
        tol=0.0,
    )
    assert evolution.fun == pytest.approx(found.value, rel=1e-4)
    assert evolution.fun >= found.value * (1.0 - 1e-9)
    assert found.agreeing == 1.0


@pytest.mark.parametrize("reading", READINGS)
def test_the_fastest_keeps_to_the_rise_and_beats_the_printed_currents(reading):
    asked = problem(shipped("lfp_8ah"), reading)
    printed = charge(asked.grid, PRINTED[None, :])
    found = fastest(asked, float(printed.rise_k(reading)[0]), starts_of(asked, 3, 4))
    best = charge(asked.grid, found.currents_a[None, :])
    assert best.rise_k(reading)[0] <= printed.rise_k(reading)[0] + 1e-7
    assert found.value < 0.95 * printed.time_s[0]


def test_a_limit_that_acts_is_kept():
    free = problem(shipped("lfp_8ah"), "peak")
    fast = best_weighted(free, Weights(time=9.0, rise=1.0), starts_of(free, 2, 5))
    reached = charge(free.grid, fast.currents_a[None, :])
    for limits in (Limits(float(reached.peak_v.max()) - 0.01, 60.0), Limits(3.65, 27.5)):
        asked = problem(shipped("lfp_8ah"), "peak", limits)
        found = best_weighted(asked, Weights(time=9.0, rise=1.0), starts_of(asked, 2, 5))
        kept = charge(asked.grid, found.currents_a[None, :])
        assert kept.peak_v.max() <= limits.voltage_v + 1e-6
        assert kept.peak_k.max() <= limits.temperature_c - 25.0 + 1e-4
        assert found.value > fast.value


def test_limits_that_nothing_keeps_to_are_an_error():
    asked = problem(shipped("lfp_8ah"), "peak", Limits(3.0, 60.0))
    with pytest.raises(ValueError, match="no start led to currents that keep to every limit"):
        best_weighted(asked, EVEN, starts_of(asked, 1, 1))


def test_the_rise_bends_upwards_over_the_stages_times():
    random = np.random.default_rng(7)
    for reading in READINGS:
        assert convex_share(problem(shipped("lfp_8ah"), reading), 500, random) == 1.0


def test_constant_currents_meet_what_they_are_asked_to():
    asked = problem(shipped("lfp_8ah"))
    printed = charge(asked.grid, PRINTED[None, :])
    found = constants(asked, PRINTED)
    assert found["same_time"].time_s == pytest.approx(printed.time_s[0], rel=1e-12)
    assert found["same_time"].current_a == pytest.approx(8 / np.sum(1 / PRINTED), rel=1e-12)
    assert found["same_peak"].peak_k == pytest.approx(printed.rise_k("peak")[0], abs=1e-9)
    assert found["same_final"].final_k == pytest.approx(printed.rise_k("final")[0], abs=1e-9)
    # One constant current warms a cooled cell to its end: highest and last rise are one.
    assert found["same_peak"].peak_k == pytest.approx(found["same_peak"].final_k, abs=1e-9)


def test_cases_do_not_lose_against_each_other():
    asked = problem(shipped("lfp_8ah"), "positive")
    weights = {"even": EVEN, "fast": Weights(time=7.0, rise=3.0)}
    cases = {case.name: case for case in best_cases(asked, weights, PRINTED, starts_of(asked, 2, 1))}
    found = {name: case.charged(asked) for name, case in cases.items()}
    for reading in READINGS:
        assert found[f"fast_best_{reading}"].time_s[0] < found[f"even_best_{reading}"].time_s[0]
        assert found[f"fast_best_{reading}"].rise_k(reading)[0] > found[f"even_best_{reading}"].rise_k(reading)[0]
    # What ends no warmer may be warmer before; what is never warmer may end warmer.
    assert found["same_final"].rise_k("final")[0] <= found["same_peak"].rise_k("final")[0] + 1e-6
    assert found["same_time_peak"].rise_k("peak")[0] <= found["same_time_final"].rise_k("peak")[0] + 1e-6


def test_the_front_falls_and_no_evolved_charge_lies_below_the_solvers():
    asked, how = problem(shipped("lfp_8ah"), "final"), FrontSettings(population=24, generations=30, weights=9)
    scan = scanned(asked, how, starts_of(asked, 1, 1))
    front = evolved(asked, how, 3)
    again = evolved(asked, how, 3)
    np.testing.assert_array_equal(front.time_s, again.time_s)
    for points in (scan, front):
        assert np.all(np.diff(points.time_s) >= 0.0)
        assert np.all(np.diff(points.rise_k) <= 1e-9)
    # The scan is a chain of optima; between two of them the front, which bends upwards, lies below the straight line.
    for time, rise in zip(front.time_s, front.rise_k, strict=True):
        best = coolest(asked, float(time), starts_of(asked, 1, 1)).value if 700 < time < 720 else -np.inf
        assert rise >= best - 1e-6


def test_gains_agree_with_the_cases():
    asked = problem(shipped("lfp_8ah_no_entropy"))
    peak, final = gains(asked, PRINTED, starts_of(asked, 2, 1))
    assert (peak.reading, final.reading) == ("peak", "final")
    assert peak.saved_share == pytest.approx(1.0 - peak.optimum.value / peak.printed_s)
    assert 0.10 < final.saved_share < peak.saved_share < 0.25
