"""Test functions of optimisation with known minima: centred, shifted or rotated, in any dimension.

Definitions: Jamil and Yang, Int. J. Math. Model. Numer. Optim. 4 (2013) 150, DOI 10.1504/IJMMNO.2013.055204.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.search.box import Box
from pipeline.search.history import Objective

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


def sphere(x: Array) -> Array:
    """Return the sum of squares: one minimum, all directions alike."""
    return _total(x**2)


def rastrigin(x: Array) -> Array:
    """Return Rastrigin's function: a bowl with a regular lattice of local minima."""
    return _total(x**2 - 10.0 * np.cos(2.0 * np.pi * x) + 10.0)


def rosenbrock(x: Array) -> Array:
    """Return Rosenbrock's function, a bent valley; in one dimension its last term alone."""
    if x.shape[-1] == 1:
        return _total((1.0 - x) ** 2)
    return _total(100.0 * (x[..., 1:] - x[..., :-1] ** 2) ** 2 + (1.0 - x[..., :-1]) ** 2)


def ackley(x: Array) -> Array:
    """Return Ackley's function: nearly flat far out, a funnel with ripples within."""
    radius = np.sqrt(_total(x**2) / x.shape[-1])
    ripple = _total(np.cos(2.0 * np.pi * x)) / x.shape[-1]
    result: Array = -20.0 * np.expm1(-0.2 * radius) - (np.exp(ripple) - np.e)
    return result


def griewank(x: Array) -> Array:
    """Return Griewank's function: a shallow bowl with many regular dips."""
    index = np.sqrt(np.arange(1, x.shape[-1] + 1))
    result: Array = np.sum(x**2, axis=-1) / 4000.0 - np.prod(np.cos(x / index), axis=-1) + 1.0
    return result


def schwefel_222(x: Array) -> Array:
    """Return Schwefel's problem 2.22: the sum and the product of the magnitudes, with a kink at the minimum."""
    magnitude = np.abs(x)
    result: Array = np.sum(magnitude, axis=-1) + np.prod(magnitude, axis=-1)
    return result


BENCHMARKS: dict[str, Benchmark] = {
    benchmark.name: benchmark
    for benchmark in (
        Benchmark("sphere", sphere, 5.12, 0.0),
        Benchmark("rastrigin", rastrigin, 5.12, 0.0),
        Benchmark("rosenbrock", rosenbrock, 2.048, 1.0),
        Benchmark("ackley", ackley, 32.768, 0.0),
        Benchmark("griewank", griewank, 600.0, 0.0),
        Benchmark("schwefel_222", schwefel_222, 10.0, 0.0),
    )
}


def shifted(benchmark: Benchmark, offset: Array) -> Objective:
    """Return the function with its minimum moved by an offset, shape (d,): no search gains by going to the middle."""

    def function(x: Array) -> Array:
        return benchmark.function(x - offset)

    return function


def rotated(benchmark: Benchmark, rotation: Array) -> Objective:
    """Return the function turned about its minimum by an orthogonal matrix (d, d): none gains along the axes."""

    def function(x: Array) -> Array:
        return benchmark.function((x - benchmark.minimum_at) @ rotation.T + benchmark.minimum_at)

    return function


def random_rotation(dimensions: int, rng: np.random.Generator) -> Array:
    """Return an orthogonal matrix, uniform over all of them (Mezzadri, Notices AMS 54 (2007) 592)."""
    q, r = np.linalg.qr(rng.standard_normal((dimensions, dimensions)))
    result: Array = q * np.sign(np.diag(r))
    return result


def _total(terms: Array) -> Array:
    total: Array = np.sum(terms, axis=-1)
    return total
