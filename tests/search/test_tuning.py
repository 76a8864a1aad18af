from __future__ import annotations

import numpy as np
import pytest

from pipeline.search import tuning
from pipeline.search.algorithms import swarm
from pipeline.search.benchmark_functions import BENCHMARKS
from pipeline.search.streams import generators

SPHERE = BENCHMARKS["sphere"].function
FACTORS = {"c1": np.array([0.5, 1.0, 2.0]), "w": np.array([0.25, 0.75, 1.0])}


@pytest.mark.parametrize("together", [1, 4, 1000])
def test_results_are_those_of_the_searches_one_by_one(swarm_settings, monkeypatch, together):
    monkeypatch.setattr(tuning, "_TOGETHER", together)
    settings = swarm_settings()
    found = tuning.results(SPHERE, settings, FACTORS, 2, "cumulative", 5)
    assert found.shape == (3, 2)
    for row in range(3):
        for column in range(2):
            knobs = swarm.Knobs(float(FACTORS["w"][row]), float(FACTORS["c1"][row]), 1.0)
            alone = swarm.run(SPHERE, settings.box(), settings, knobs, generators(5, 2 * row + column, 1))
            assert found[row, column] == pytest.approx(alone.value[0, 1:].sum(), rel=1e-12)


def test_the_knobs_that_are_tuned_may_still_be_references(swarm_settings):
    reference = {"from": "tuning", "value": "x"}
    settings = swarm_settings(c1=reference, w=reference)
    found = tuning.results(SPHERE, settings, FACTORS, 1, "final", 5)
    np.testing.assert_array_equal(found, tuning.results(SPHERE, swarm_settings(), FACTORS, 1, "final", 5))


def test_a_factor_that_is_no_knob_is_refused(swarm_settings):
    with pytest.raises(ValueError, match=r"factors are \['c3'\]; the swarm's knobs are \['w', 'c1', 'c2'\]"):
        tuning.results(SPHERE, swarm_settings(), {"c3": np.array([1.0])}, 1, "final", 5)
