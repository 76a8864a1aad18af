from __future__ import annotations

import itertools

import numpy as np
import pytest

from pipeline.search.chaos import logistic
from pipeline.search.streams import STREAMS, generators


@pytest.mark.parametrize("rand", STREAMS)
def test_a_replicate_sees_the_same_numbers_alone(rand):
    together = list(STREAMS[rand](generators(7, 0, 4), (2, 3, 1), 6))
    alone = list(STREAMS[rand](generators(7, 2, 1), (2, 3, 1), 6))
    assert len(together) == 6
    for many, one in zip(together, alone, strict=True):
        assert many.shape == (4, 2, 3, 1)
        np.testing.assert_array_equal(many[2], one[0])


@pytest.mark.parametrize("rand", STREAMS)
def test_the_two_rand_of_the_equation_are_different_streams(rand):
    drawn = np.stack(list(STREAMS[rand](generators(1, 0, 50), (2, 10, 1), 100)))
    first, second = drawn[:, :, 0].ravel(), drawn[:, :, 1].ravel()
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.02
    assert np.min(drawn) >= 0.0
    assert np.max(drawn) <= 1.0
    assert np.mean(drawn) == pytest.approx(0.5, abs=0.01)
    assert np.var(drawn) == pytest.approx(1 / 12 if rand == "uniform" else 1 / 8, abs=2e-3)


def test_only_the_chaotic_stream_is_an_orbit():
    for rand, stream in STREAMS.items():
        drawn = list(stream(generators(1, 0, 3), (2, 5, 2), 4))
        same = all(np.array_equal(logistic(now), after) for now, after in itertools.pairwise(drawn))
        assert same == (rand == "logistic"), rand


def test_seeds_and_replicates_differ():
    first = [generator.random() for generator in generators(1, 0, 5)]
    assert len(set(first)) == 5
    assert first[3] == generators(1, 3, 1)[0].random()
    assert first != [generator.random() for generator in generators(2, 0, 5)]
