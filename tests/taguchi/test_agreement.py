from __future__ import annotations

import numpy as np
import pytest

from pipeline.taguchi.analysis import agreement
from pipeline.taguchi.arrays import full_factorial

COUNTS = (4, 4, 4)
EFFECTS = np.array([[0.3, 0.0, 0.2, 0.4], [0.1, 0.2, 0.3, 0.0], [0.2, 0.5, 0.0, 0.1]])


def additive(noise, replicates, seed=1):
    combinations = full_factorial(COUNTS)
    means = sum(EFFECTS[factor, combinations[:, factor]] for factor in range(3))
    return means[:, None] + noise * np.random.default_rng(seed).normal(size=(64, replicates))


def test_an_additive_response_without_noise_is_always_found(array):
    found = agreement(array, COUNTS, additive(0.0, 4), 1)
    assert found.experiments == 4
    assert found.best == (1, 3, 2)
    assert found.found_share == found.factorial_found_share == 1.0
    assert found.factor_shares == (1.0, 1.0, 1.0)
    assert found.mean_rank == 1.0
    assert found.mean_regret == 0.0


def test_noise_alone_is_chance(array):
    rng = np.random.default_rng(2)
    found = [agreement(array, COUNTS, rng.normal(size=(64, 4)), 1) for _ in range(500)]
    assert np.mean([one.found_share for one in found]) == pytest.approx(1 / 64, abs=0.007)
    assert np.mean([one.factorial_found_share for one in found]) == pytest.approx(1 / 64, abs=0.007)
    assert np.mean([one.mean_rank for one in found]) == pytest.approx(32.5, abs=1.5)
    assert np.mean([one.mean_rank_of_best_run for one in found]) == pytest.approx(32.5, abs=1.5)
    assert np.mean([one.factor_shares for one in found], axis=0) == pytest.approx([0.25] * 3, abs=0.03)


def test_averaging_helps(array):
    results = additive(0.3, 400)
    once, averaged = agreement(array, COUNTS, results, 1), agreement(array, COUNTS, results, 20)
    assert averaged.experiments == 20
    assert once.found_share < averaged.found_share
    assert averaged.mean_rank < once.mean_rank < 32.5


def test_an_experiment_cannot_judge_itself(array):
    with pytest.raises(ValueError, match="searches_per_run is 3; at most half of 5 are allowed"):
        agreement(array, COUNTS, additive(0.1, 5), 3)
