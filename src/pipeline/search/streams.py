"""The swarm's two `Rand` of eq. (2) as streams of numbers in [0, 1], for all replicates together.

Each replicate draws from a generator of its own, so it sees the same numbers whatever runs beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pipeline.search.chaos import arcsine, guarded, logistic

Array = NDArray[np.float64]
Generators: TypeAlias = Sequence[np.random.Generator]
Rand = Literal["uniform", "logistic", "arcsine"]


def uniform(generators: Generators, shape: tuple[int, ...], steps: int) -> Iterator[Array]:
    """Yield independent uniform numbers, shape (r, *shape) each of `steps` times."""
    drawn = np.stack([generator.random((steps, *shape)) for generator in generators], axis=1)
    yield from drawn


def independent_arcsine(generators: Generators, shape: tuple[int, ...], steps: int) -> Iterator[Array]:
    """Yield independent numbers with the density of the logistic map: what tells chaos from its density."""
    for drawn in uniform(generators, shape, steps):
        yield arcsine(drawn)


def chaotic(generators: Generators, shape: tuple[int, ...], steps: int) -> Iterator[Array]:
    """Yield the logistic map at r = 4; every entry is an orbit of its own, from a random, guarded start."""
    state = guarded(np.stack([generator.random(shape) for generator in generators]))
    for _ in range(steps):
        yield state
        state = guarded(logistic(state))


STREAMS: dict[Rand, Callable[[Generators, tuple[int, ...], int], Iterator[Array]]] = {
    "uniform": uniform,
    "logistic": chaotic,
    "arcsine": independent_arcsine,
}


def generators(seed: int, first: int, count: int) -> list[np.random.Generator]:
    """Return the generators of replicates first, first + 1, ...: number i draws from SeedSequence([seed, i])."""
    return [np.random.default_rng(np.random.SeedSequence([seed, first + index])) for index in range(count)]
