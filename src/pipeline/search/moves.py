"""The moves of cuckoo search as kernels; `algorithms/cuckoo.py` says what they are and where from.

`fly`, `walk` and `keep` move the nests of one replicate. `advance` runs whole generations with them and calls a
compiled objective itself; for any other objective `fly_all`, `walk_all` and `keep_all` take all replicates one move on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numba import float64, void
from numpy.typing import NDArray

from pipeline.jit import by_address, inlined, jit, kernel
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


Array = NDArray[np.float64]


class Law(NamedTuple):
    """What rules the moves: the settings that are numbers, and the box."""

    pa: float
    step_scale: float
    ki: float
    leak: float
    low: Array
    """Shape (d,)."""
    high: Array
    """Shape (d,)."""


class Nests(NamedTuple):
    """The nests, for r replicates of n nests in d dimensions; every move writes to them."""

    position: Array
    """Shape (r, n, d)."""
    value: Array
    """Shape (r, n)."""
    integral: Array
    """Leaky sum of the distances to the best nest, shape (r, n, d)."""
    leader: NDArray[np.int64]
    """Best nest of each replicate, shape (r,)."""

    def of(self, replicates: slice) -> Nests:
        """Return the nests of some replicates, the same in memory."""
        return Nests(
            self.position[replicates], self.value[replicates], self.integral[replicates], self.leader[replicates]
        )


class Course(NamedTuple):
    """The best nest of each replicate, row by row, t rows."""

    position: Array
    """Shape (r, t, d)."""
    value: Array
    """Shape (r, t)."""


@kernel
def fly(
    position: Array, leader: int, integral: Array, levy: Array, weight: float, law: Law, candidate: Array
) -> None:  # fmt: skip
    """Write where the Levy flights lead, within the box, and the new integral; arrays of shape (n, d)."""
    for n in range(position.shape[0]):
        for d in range(position.shape[1]):
            error = position[leader, d] - position[n, d]
            summed = law.leak * integral[n, d] + error
            free = weight * position[n, d] - law.step_scale * levy[n, d] * error + law.ki * summed
            integral[n, d] = summed
            candidate[n, d] = min(max(free, law.low[d]), law.high[d])


@kernel
def walk(
    position: Array, partners: NDArray[np.int64], length: Array, chance: Array, law: Law, candidate: Array
) -> None:  # fmt: skip
    """Write where the biased walks lead, X + length H(pa - chance) (X_j - X_k), within the box, shape (n, d)."""
    for n in range(position.shape[0]):
        first, second = partners[0, n], partners[1, n]
        for d in range(position.shape[1]):
            away = length[n] * (position[first, d] - position[second, d])
            free = position[n, d] + (away if chance[n, d] < law.pa else 0.0)
            candidate[n, d] = min(max(free, law.low[d]), law.high[d])


@kernel
def keep(position: Array, value: Array, candidate: Array, found: Array) -> int:
    """Move each nest to its candidate (n, d) where what was found there (n,) is no worse; return the best nest."""
    leader = 0
    for n in range(position.shape[0]):
        if found[n] <= value[n]:
            value[n] = found[n]
            for d in range(position.shape[1]):
                position[n, d] = candidate[n, d]
        if value[n] < value[leader]:
            leader = n
    return leader


@jit
def advance(
    objective: Kernel, numbers: Array, law: Law, weights: Array, drawn: Draws, nests: Nests, course: Course, row: int
) -> None:  # fmt: skip
    """Run generations with an objective's kernel, replicate after replicate.

    Arguments
    ---------
    objective, numbers : the kernel, and what it takes beside the positions.
    weights : the inertia w of each generation [1].
    drawn : the random numbers of at least as many generations.
    course : is written, from `row` on.
    """
    replicates, count, dimensions = nests.position.shape
    candidate, found = np.empty((count, dimensions)), np.empty(count)
    for r in range(replicates):
        position, value, leader = nests.position[r], nests.value[r], nests.leader[r]
        for g in range(len(weights)):
            fly(position, leader, nests.integral[r], drawn.levy[r, g], weights[g], law, candidate)
            objective(numbers, candidate, found)
            leader = keep(position, value, candidate, found)
            walk(position, drawn.partners[r, g], drawn.length[r, g], drawn.chance[r, g], law, candidate)
            objective(numbers, candidate, found)
            leader = keep(position, value, candidate, found)
            course.value[r, row + g] = value[leader]
            for d in range(dimensions):
                course.position[r, row + g, d] = position[leader, d]
        nests.leader[r] = leader


@jit
def fly_all(law: Law, weight: float, drawn: Draws, g: int, nests: Nests, candidate: Array) -> None:
    """Write where the flights of generation g of a block lead, shape (r, n, d)."""
    for r in range(len(candidate)):
        fly(nests.position[r], nests.leader[r], nests.integral[r], drawn.levy[r, g], weight, law, candidate[r])


@jit
def walk_all(law: Law, drawn: Draws, g: int, nests: Nests, candidate: Array) -> None:
    """Write where the walks of generation g of a block lead, shape (r, n, d)."""
    for r in range(len(candidate)):
        position, partners = nests.position[r], drawn.partners[r, g]
        walk(position, partners, drawn.length[r, g], drawn.chance[r, g], law, candidate[r])


@jit
def keep_all(nests: Nests, candidate: Array, found: Array) -> None:
    """Move the nests of all replicates to what was found (r, n) at their candidates (r, n, d) where it is no worse."""
    for r in range(len(candidate)):
        nests.leader[r] = keep(nests.position[r], nests.value[r], candidate[r], found[r])


Kernel = Callable[[Array, Array, Array], None]
"""Numbers that say which problem it is (m,), positions (n, d), and the values (n,) that it writes."""

_SIGNATURE = void(float64[::1], float64[:, ::1], float64[::1])


class Compiled:
    """An objective as any other: positions (n, d) to values (n,); and its kernel for those who can call it."""

    def __init__(self, kernel: Kernel, numbers: Array) -> None:
        self._kernel = kernel
        self.jitted = jit(kernel)
        self.numbers = np.ascontiguousarray(numbers, dtype=np.float64)

    def __call__(self, positions: Array) -> Array:
        """Return the values (n,) of positions (n, d)."""
        values = np.empty(len(positions))
        self.jitted(self.numbers, np.ascontiguousarray(positions, dtype=np.float64), values)
        return values

    @cached_property
    def address(self) -> Any:
        """Return the kernel in the one type that all kernels share, so that a search is compiled once for all."""
        return by_address(_SIGNATURE, self._kernel)


_TERMS = 12
# Taylor's series of sin(pi x); at x = 1/2 the first term left out is below 1e-19.
_SERIES = tuple((-1.0) ** k * math.pi ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(_TERMS))


@inlined
def sine(half_turns: float) -> float:
    """Return sin(pi x) of -1/2 <= x <= 1/2, to the last digit but one."""
    square = half_turns * half_turns
    total = _SERIES[_TERMS - 1]
    for k in range(_TERMS - 2, -1, -1):
        total = total * square + _SERIES[k]
    return half_turns * total


@inlined
def sine_squared(half_turns: float) -> float:
    """Return sin(pi x)^2 of any x; 2 sin(pi x)^2 is 1 - cos(2 pi x) without its cancellation near whole numbers."""
    # numpy's floor stays a float: several are rounded at once.
    found = sine(half_turns - np.floor(half_turns + 0.5))
    return found * found
