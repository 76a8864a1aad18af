"""The configured swarm on the configured objective: does it find what brute force finds, and does chaos help."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.objective.optimum import objective, optimal_frequency_hz, steps, switched_currents_a, switching_energy_j
from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from pipeline.search.comparison import compare, final_distance, iterations_within
from pipeline.search.registry import replicated, settings_from
from tests.cards import card

WAVEFORM = Waveform(charge_a=2.1, charge_share=0.90, discharge_a=0.5, discharge_share=0.05)
PAIRS = Pairs((0.015, 0.030), (0.006, 0.6))


@pytest.fixture(scope="module")
def problem():
    settings = ReflexFrequency(**card("objective"))
    period, energy = steps(WAVEFORM), switching_energy_j(settings.transistor, switched_currents_a(WAVEFORM))
    best = float(optimal_frequency_hz(period, PAIRS, energy))
    return objective(period, PAIRS, energy, settings.window_s), best


@pytest.fixture(scope="module")
def histories(problem):
    values = {**card("search"), "c1": 1.0, "c2": 1.0, "w": 0.75, "replicates": 2000}
    return {
        rand: replicated(problem[0], settings_from({**values, "rand": rand}), 20150401)
        for rand in ("logistic", "uniform", "arcsine")
    }


def test_sweep_finds_the_optimum(problem):
    evaluate, best = problem
    found = replicated(evaluate, settings_from(card("oracle")), 1)
    assert found.best_position()[0, 0] == pytest.approx(best, abs=1e-3)


def test_every_swarm_finds_the_optimum(problem, histories):
    for rand, history in histories.items():
        distance = np.abs(history.best_position()[:, 0] - problem[1])
        assert history.value.shape == (2000, 31)
        assert np.quantile(distance, 0.999) < 1.0, rand
        assert np.mean(distance) < 0.05, rand


def test_chaos_brings_no_advantage_here(problem, histories):
    best = problem[1]
    measures = {"iterations": iterations_within(best, 1.0), "distance": final_distance(best)}
    summaries, differences = compare(histories, measures, np.random.default_rng(1), resamples=500)
    assert all(row.arrived_share == 1.0 for row in summaries)
    assert all(5.0 < row.mean.value < 6.5 for row in summaries if row.measure == "iterations")
    larger = {(row.first, row.second, row.measure): row.larger for row in differences}
    # Chaos ends farther off than uniform numbers; part of that is its density, part the order of its values.
    assert larger["logistic", "uniform", "distance"].low > 0.55
    assert larger["logistic", "arcsine", "distance"].low > 0.5
    assert larger["uniform", "arcsine", "distance"].high < 0.5
    assert larger["logistic", "uniform", "iterations"].low > 0.5
