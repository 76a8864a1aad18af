from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from pipeline.search.box import History, iterations_until
from pipeline.search.comparison import (
    compare,
    effect,
    final_distance,
    iterations_within,
    mean_with_interval,
    vargha_delaney,
)


def history(paths):
    position = np.array(paths, dtype=float)[:, :, None]
    return History(np.zeros(position.shape[:2], dtype=np.int64), position, np.abs(position[:, :, 0]))


def test_chance_of_being_larger_counts_pairs():
    assert vargha_delaney([1, 2, 3], [0, 0, 0]) == 1.0
    assert vargha_delaney([1, 2], [1, 2]) == 0.5
    assert vargha_delaney([1, 3], [2, 3]) == pytest.approx((0 + 0 + 1 + 0.5) / 4)
    assert vargha_delaney([np.inf, 1], [np.inf, 5]) == pytest.approx((0.5 + 1 + 0 + 0) / 4)


def test_it_is_the_mann_whitney_statistic():
    rng = np.random.default_rng(1)
    first, second = rng.integers(0, 9, 60), rng.integers(1, 12, 45)
    assert vargha_delaney(first, second) == pytest.approx(mannwhitneyu(first, second).statistic / (60 * 45))


def test_interval_holds_the_truth_as_often_as_it_says():
    # P(X > Y) for two normals half a deviation apart is Phi(0.5 / sqrt 2) = 0.638.
    rng, truth, hits = np.random.default_rng(2), 0.638163, 0
    for _ in range(200):
        found = effect(rng.normal(0.5, 1.0, 60), rng.normal(0.0, 1.0, 60), rng, resamples=400)
        assert found.low <= found.value <= found.high
        hits += found.low <= truth <= found.high
    assert 0.90 <= hits / 200 <= 0.99


def test_resamples_are_drawn_from_both_with_their_ties():
    first, second = [1.0, 2.0, 2.0, 3.0], [2.0, 2.0, 0.0]
    found = effect(first, second, np.random.default_rng(5), confidence=0.8, resamples=20_000)
    rng = np.random.default_rng(6)
    drawn = [vargha_delaney(rng.choice(first, 4), rng.choice(second, 3)) for _ in range(20_000)]
    np.testing.assert_allclose([found.low, found.high], np.quantile(drawn, [0.1, 0.9]), atol=0.02)


def test_interval_of_a_mean():
    values = np.random.default_rng(3).normal(10.0, 2.0, 400)
    found = mean_with_interval(values, np.random.default_rng(4))
    assert found.value == pytest.approx(np.mean(values))
    assert found.high - found.low == pytest.approx(2 * 1.96 * 2.0 / 20.0, rel=0.15)


def test_iterations_until_a_condition_stays():
    held = np.array([[0, 1, 0, 1, 1], [1, 1, 1, 1, 1], [0, 1, 1, 1, 0], [0, 0, 0, 0, 1]], dtype=bool)
    assert iterations_until(held).tolist() == [3.0, 0.0, np.inf, 4.0]


def test_comparison_of_two_searches():
    slow, fast = history([[9, 5, 2, 0.5], [9, 9, 9, 9]]), history([[9, 0.2, 0.2, 0.1], [3, 0.9, 0.5, 0.0]])
    measures = {"iterations": iterations_within(0.0, 1.0), "distance": final_distance(0.0)}
    summaries, differences = compare({"slow": slow, "fast": fast}, measures, np.random.default_rng(1))
    by = {(row.search, row.measure): row for row in summaries}
    assert by["slow", "iterations"].mean.value == 3.0
    assert by["slow", "iterations"].arrived_share == 0.5
    assert by["fast", "iterations"].mean.value == 1.0
    assert by["fast", "distance"].mean.value == pytest.approx(0.05)
    assert [(row.first, row.second, row.larger.value) for row in differences] == [("slow", "fast", 1.0)] * 2
