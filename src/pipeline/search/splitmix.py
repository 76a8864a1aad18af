"""Uniform random numbers that are drawn many at once: each is a hash of its place in the sequence.

SplitMix64: Steele, Lea and Flood, Fast splittable pseudorandom number generators, OOPSLA 2014, DOI
10.1145/2660193.2660195. No number waits for the one before, so a processor mixes several at a time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import jit

_STEP, _FIRST, _SECOND = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_BY_FIRST, _BY_SECOND, _BY_LAST, _SPARE_BITS = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_LAST_BIT = 2.0**-53


def uniform(rng: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return numbers in [0, 1), from a key that is drawn from a generator."""
    numbers = np.empty(shape)
    fill(rng.integers(2**64, dtype=np.uint64), numbers.reshape(-1))
    return numbers


@jit
def fill(key: np.uint64, numbers: NDArray[np.float64]) -> None:
    """Write the sequence of a key, numbers in [0, 1) of 53 bits."""
    for i in range(len(numbers)):
        mixed = key + np.uint64(i) * _STEP
        mixed = (mixed ^ (mixed >> _BY_FIRST)) * _FIRST
        mixed = (mixed ^ (mixed >> _BY_SECOND)) * _SECOND
        mixed = mixed ^ (mixed >> _BY_LAST)
        numbers[i] = np.float64(mixed >> _SPARE_BITS) * _LAST_BIT
