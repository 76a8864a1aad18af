"""Test functions of optimisation with known minima: centred, shifted or rotated, in any dimension.

Definitions: Jamil and Yang, Int. J. Math. Model. Numer. Optim. 4 (2013) 150, DOI 10.1504/IJMMNO.2013.055204. Each takes
positions (n, d) and returns values (n,); a row's value does not depend, to the last bit, on the rows beside it.
"""

from __future__ import annotations

import math
import zlib
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import jit
from pipeline.search.box import Box, Objective
from pipeline.search.function_records import CENTRED, HALF_WIDTHS, ROTATED
from pipeline.search.moves import Compiled, sine_squared

Array = NDArray[np.float64]


class Benchmark(NamedTuple):
    """A function on a cube; its minimum is 0 at the same coordinate in every dimension."""

    name: str
    function: Objective
    half_width: float
    minimum_at: float

    def box(self, dimensions: int) -> Box:
        """Return the usual cube around the origin."""
        edge = np.full(dimensions, self.half_width)
        return Box(-edge, edge)


@jit
def _sums(terms: Array) -> Array:
    """Return the sum of each row, (n, d) to (n,)."""
    values = np.zeros(len(terms))
    for i in range(terms.shape[0]):
        total = 0.0
        for j in range(terms.shape[1]):
            total += terms[i, j]
        values[i] = total
    return values


@jit
def sphere(x: Array) -> Array:
    """Return the sum of squares: one minimum, all directions alike."""
    return _sums(x * x)


@jit
def schwefel_222(x: Array) -> Array:
    """Return Schwefel's problem 2.22: the sum and the product of the magnitudes, with a kink at the minimum."""
    values = np.zeros(len(x))
    for i in range(x.shape[0]):
        product = 1.0
        for j in range(x.shape[1]):
            values[i] += abs(x[i, j])
            product *= abs(x[i, j])
        values[i] += product
    return values


@jit
def schwefel_12(x: Array) -> Array:
    """Return Schwefel's problem 1.2: the sum of the squares of all partial sums, a long slanting valley."""
    values = np.zeros(len(x))
    for i in range(x.shape[0]):
        partial = 0.0
        for j in range(x.shape[1]):
            partial += x[i, j]
            values[i] += partial * partial
    return values


@jit
def rosenbrock(x: Array) -> Array:
    """Return Rosenbrock's function, a bent valley; in one dimension its last term alone."""
    values = np.zeros(len(x))
    for i in range(x.shape[0]):
        if x.shape[1] == 1:
            values[i] = (1.0 - x[i, 0]) ** 2
        for j in range(x.shape[1] - 1):
            values[i] += 100.0 * (x[i, j + 1] - x[i, j] ** 2) ** 2 + (1.0 - x[i, j]) ** 2
    return values


@jit
def rastrigin(x: Array) -> Array:
    """Return Rastrigin's function: a bowl with a regular lattice of local minima."""
    terms, flat = np.empty(x.size), x.flatten()
    for k in range(x.size):
        terms[k] = flat[k] * flat[k] + 20.0 * sine_squared(flat[k])
    return _sums(terms.reshape(x.shape))


@jit
def griewank(x: Array) -> Array:
    """Return Griewank's function: a shallow bowl with many regular dips."""
    values, roots = np.zeros(len(x)), np.sqrt(np.arange(1.0, x.shape[1] + 1.0))
    for i in range(x.shape[0]):
        product = 1.0
        for j in range(x.shape[1]):
            values[i] += x[i, j] * x[i, j] / 4000.0
            product *= math.cos(x[i, j] / roots[j])
        values[i] += 1.0 - product
    return values


@jit
def ackley(x: Array) -> Array:
    """Return Ackley's function: nearly flat far out, a funnel with ripples within."""
    values = np.empty(len(x))
    sines, flat = np.empty(x.size), x.flatten()
    for k in range(x.size):
        sines[k] = sine_squared(flat[k])
    squares, ripples = sphere(x), _sums(sines.reshape(x.shape))
    for i in range(x.shape[0]):
        bowl = -20.0 * math.expm1(-0.2 * math.sqrt(squares[i] / x.shape[1]))
        # The mean cosine of 2 pi x is 1 - 2 sin^2(pi x): near the minimum nothing cancels.
        values[i] = bowl - math.e * math.expm1(-2.0 * ripples[i] / x.shape[1])
    return values


BENCHMARKS: dict[str, Benchmark] = {
    function.__name__: Benchmark(
        function.__name__, function, HALF_WIDTHS[function.__name__], float(function is rosenbrock)
    )
    for function in (sphere, schwefel_222, schwefel_12, rosenbrock, rastrigin, griewank, ackley)
}


class Problem(NamedTuple):
    """A function as it is searched; its minimum is 0."""

    objective: Objective
    box: Box
    minimum_at: Array
    """Where the minimum is, shape (d,)."""


def problem(name: str, placement: str, dimensions: int, shift_share: float, seed: int) -> Problem:
    """Return a function in one of its placements; the same seed gives the same place, whatever else is asked for.

    Arguments
    ---------
    name : of the function.
    placement : `centred`: as it is defined; `shifted`: its minimum moved to a random place; `rotated`: that, and turned
        about it by a random orthogonal matrix.
    dimensions : d.
    shift_share : how far from the centre the minimum may be moved, over the half width of the box [1].
    seed : root of the random place and matrix.
    """
    benchmark = BENCHMARKS[name]
    box = benchmark.box(dimensions)
    if placement == CENTRED:
        place = np.full(dimensions, benchmark.minimum_at)
        return Problem(placed(benchmark, place), box, place)
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    place = benchmark.half_width * shift_share * rng.uniform(-1.0, 1.0, dimensions)
    rotation = random_rotation(dimensions, rng) if placement == ROTATED else None
    return Problem(placed(benchmark, place, rotation), box, place)


def placed(benchmark: Benchmark, minimum_at: Array, rotation: Array | None = None) -> Compiled:
    """Return the function with its minimum moved to a place (d,), and turned about it by a matrix (d, d), if given."""
    turn = np.empty(0) if rotation is None else rotation.T.ravel()
    head = [list(BENCHMARKS).index(benchmark.name), benchmark.minimum_at]
    return Compiled(_placed, np.concatenate([head, minimum_at - benchmark.minimum_at, turn]))


def shifted(benchmark: Benchmark, offset: Array) -> Compiled:
    """Return the function with its minimum moved by an offset, shape (d,): no search gains by going to the middle."""
    return placed(benchmark, benchmark.minimum_at + offset)


def rotated(benchmark: Benchmark, rotation: Array) -> Compiled:
    """Return the function turned about its minimum by an orthogonal matrix (d, d): none gains along the axes."""
    return placed(benchmark, np.full(len(rotation), benchmark.minimum_at), rotation)


def random_rotation(dimensions: int, rng: np.random.Generator) -> Array:
    """Return an orthogonal matrix, uniform over all of them (Mezzadri, Notices AMS 54 (2007) 592)."""
    q, r = np.linalg.qr(rng.standard_normal((dimensions, dimensions)))
    result: Array = q * np.sign(np.diag(r))
    return result


def _placed(place: Array, x: Array, values: Array) -> None:
    """Write the values of positions (n, d).

    Arguments
    ---------
    place : which of the functions, the coordinate of its minimum, how far it is moved (d,), and the columns of the
        matrix that it is turned by (d * d,), if it is.
    """
    dimensions = x.shape[1]
    moved = np.empty_like(x)
    for i in range(x.shape[0]):
        for j in range(dimensions):
            moved[i, j] = x[i, j] - place[2 + j]
    if len(place) > 2 + dimensions:
        moved = _turned(moved, place[1], place[2 + dimensions :].reshape(dimensions, dimensions))
    values[:] = _value(int(place[0]), moved)


@jit
def _value(number: int, x: Array) -> Array:
    # One kernel for all: a function of its own for each would be compiled for each placement.
    if number == 0:
        return sphere(x)
    if number == 1:
        return schwefel_222(x)
    if number == 2:
        return schwefel_12(x)
    if number == 3:
        return rosenbrock(x)
    if number == 4:
        return rastrigin(x)
    if number == 5:
        return griewank(x)
    return ackley(x)


@jit
def _turned(x: Array, about: float, columns: Array) -> Array:
    # Not a matrix product of numpy's: its last bits depend on how many rows it is given.
    turned = np.full(x.shape, about)
    for i in range(x.shape[0]):
        for k in range(x.shape[1]):
            away = x[i, k] - about
            for j in range(x.shape[1]):
                turned[i, j] += columns[k, j] * away
    return turned
