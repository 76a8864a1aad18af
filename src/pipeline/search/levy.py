"""The random numbers of cuckoo search: Levy flights and random walks, for many generations at once.

Levy numbers by Mantegna, Phys. Rev. E 49 (1994) 4677, DOI 10.1103/PhysRevE.49.4677.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import jit
from pipeline.search.compiled import sine
from pipeline.search.streams import Generators

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


Array = NDArray[np.float64]

BLOCK = 60  # generations drawn at once; fixed, so that a longer search begins like a shorter one
_SMALLEST = 1e-300


class Draws(NamedTuple):
    """The random numbers of a block of g generations, for r replicates of n nests in d dimensions."""

    levy: Array
    """Levy number times a normal one, shape (r, g, n, d)."""
    partners: NDArray[np.int64]
    """Two permutations of the nests, shape (r, g, 2, n)."""
    length: Array
    """Length of each nest's walk, in [0, 1), shape (r, g, n)."""
    chance: Array
    """Uniform number of each coordinate: it walks where that is below pa; shape (r, g, n, d)."""


def mantegna_deviation(exponent: float) -> float:
    """Return the deviation of the numerator u in Mantegna's Levy number u / |v|^(1/exponent); 0.6966 for 1.5."""
    above = math.gamma(1.0 + exponent) * math.sin(0.5 * math.pi * exponent)
    below = math.gamma(0.5 * (1.0 + exponent)) * exponent * 2.0 ** (0.5 * (exponent - 1.0))
    return float((above / below) ** (1.0 / exponent))


def draws(nests: int, dimensions: int, exponent: float, random: Generators) -> Iterator[Draws]:
    """Yield the numbers of block after block; each replicate draws from its own generator, whatever runs beside it."""
    while True:
        blocks = [_block(nests, dimensions, exponent, generator) for generator in random]
        # A single replicate is the usual case in a search of its own: nothing to copy.
        yield Draws(*(np.stack(part) if len(part) > 1 else part[0][None] for part in zip(*blocks, strict=True)))


def levy_numbers(drawn: Array, exponent: float) -> Array:
    """Return Levy numbers times normal ones, u w / |v|^(1/exponent), from four uniform numbers each.

    After Box and Muller, Ann. Math. Stat. 29 (1958) 610, DOI 10.1214/aoms/1177706645: with an exponential number E and
    a uniform angle, E sin(angle) is the product u w of two normal numbers, and 2 E sin(angle)^2 the square of one.

    Arguments
    ---------
    drawn : uniform in [0, 1), shape (4, ...).
    exponent : of the Levy law, between 1 and 2.

    Returns
    -------
    Shape (...).
    """
    # 1 - u is never zero. Logarithm and exponential together take numpy less time than a power.
    minus_exponential = np.subtract(1.0, drawn[:2])
    np.log(minus_exponential, out=minus_exponential)
    product, square = np.empty(drawn.shape[1:]), np.empty(drawn.shape[1:])
    _normal(minus_exponential.reshape(2, -1), drawn[2:].reshape(2, -1), product.reshape(-1), square.reshape(-1))
    np.log(square, out=square)
    square *= -0.5 / exponent
    np.exp(square, out=square)
    square *= mantegna_deviation(exponent)
    product *= square
    return product


@jit
def _normal(minus_exponential: Array, angle: Array, product: Array, square: Array) -> None:
    """Write products of two normal numbers and squares of one, shape (m,), from numbers of shape (2, m)."""
    for i in range(len(product)):
        product[i] = -minus_exponential[0, i] * sine(angle[0, i] - 0.5)
        half_width = sine(angle[1, i] - 0.5)
        square[i] = max(-2.0 * minus_exponential[1, i] * half_width * half_width, _SMALLEST)


@jit
def permutations(drawn: Array) -> NDArray[np.int64]:
    """Return a permutation of 0 to n - 1 for each row of n uniform numbers (Fisher and Yates), shape (m, n)."""
    rows, count = drawn.shape
    order = np.empty((rows, count), dtype=np.int64)
    for row in range(rows):
        for place in range(count):
            order[row, place] = place
        for place in range(count - 1, 0, -1):
            other = int(drawn[row, place] * (place + 1))
            order[row, place], order[row, other] = order[row, other], order[row, place]
    return order


def _block(
    nests: int, dimensions: int, exponent: float, rng: np.random.Generator
) -> tuple[Array, NDArray[np.int64], Array, Array]:
    coordinates = uniform(rng, (5, BLOCK, nests, dimensions))
    partners = permutations(uniform(rng, (2 * BLOCK, nests))).reshape(BLOCK, 2, nests)
    return levy_numbers(coordinates[:4], exponent), partners, uniform(rng, (BLOCK, nests)), coordinates[4]
