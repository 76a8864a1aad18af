"""SplitMix64 against its published numbers and its definition; uniform numbers against their law."""

from __future__ import annotations

import numpy as np
from scipy.stats import kstest

from pipeline.search.moves import fill, uniform

_MASK = 2**64 - 1


def mixed(value):
    value = ((value ^ (value >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    value = ((value ^ (value >> 27)) * 0x94D049BB133111EB) & _MASK
    return value ^ (value >> 31)


def test_the_definition_gives_the_published_numbers():
    # Steele's generator from the seed 1234567, as its reference implementation prints it.
    step, published = 0x9E3779B97F4A7C15, [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert [mixed((1234567 + k * step) & _MASK) for k in (1, 2, 3)] == published


def test_the_kernel_is_the_definition():
    for key in (0, 1, 2**64 - 1, 0x0123456789ABCDEF):
        numbers = np.empty(100)
        fill(np.uint64(key), numbers)
        expected = [(mixed((key + i * 0x9E3779B97F4A7C15) & _MASK) >> 11) / 2**53 for i in range(100)]
        assert numbers.tolist() == expected


def test_numbers_are_uniform_and_independent_of_their_neighbours():
    rng = np.random.default_rng(2)
    numbers = uniform(rng, (5, 40_000))
    assert kstest(numbers.ravel(), "uniform").pvalue > 0.01
    assert np.abs(np.corrcoef(numbers) - np.eye(5)).max() < 4.0 / np.sqrt(40_000)
    lagged = [np.corrcoef(numbers[0, lag:], numbers[0, :-lag])[0, 1] for lag in (1, 2, 8, 200)]
    assert np.abs(lagged).max() < 4.0 / np.sqrt(40_000)
    assert not np.array_equal(uniform(rng, (5,)), numbers[0, :5])
