"""Cuckoo search, plain, with inertia, and with an integral term, all replicates advanced together as arrays.

Plain: Yang and Deb, Cuckoo search via Levy flights, NaBIC 2009, DOI 10.1109/NABIC.2009.5393690, with the steps of their
published program: Levy numbers by Mantegna, Phys. Rev. E 49 (1994) 4677, DOI 10.1103/PhysRevE.49.4677, times a normal
one, 0.01 of the distance to the best nest; a biased walk; greedy choice after both.

The paper's own formulas are lost. With e = best nest - X its words fix them: plain search is "a discrete proportional
control", inertia multiplies X by w, and "the integral is added, the rest unchanged":

    X(t+1) = w X(t) + Kp e(t) + Ki (e(t) + leak e(t-1) + leak^2 e(t-2) + ...)

Here Kp is the random -0.01 L of the flight. The leak is ours: without one the sum goes on long after the best nest has
moved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pipeline.search.box import Box, SearchSettings
from pipeline.search.history import History, Objective
from pipeline.search.streams import Generators, generators

Array = NDArray[np.float64]

_BLOCK = 32  # generations drawn at once; fixed, so that a longer search begins like a shorter one
_SMALLEST = 1e-300


class Settings(SearchSettings):
    """The settings of the family; as they stand by default it is plain cuckoo search."""

    kind: Literal["cuckoo"] = "cuckoo"
    nests: int = Field(ge=3, description="nests [1]")
    generations: int = Field(ge=1, description="flights and walks of all nests, after their random start [1]")
    pa: float = Field(default=0.25, ge=0, le=1, description="chance that a coordinate of a nest takes the walk [1]")
    step_scale: float = Field(default=0.01, gt=0, description="Levy step over the distance to the best nest [1]")
    levy_exponent: float = Field(default=1.5, gt=1, lt=2, description="exponent of the Levy law [1]")
    inertia: float = Field(default=1.0, ge=0, le=1, description="weight w of a nest's own position; 1: plain [1]")
    inertia_end: float | None = Field(
        default=None, ge=0, le=1, description="weight in the last generation, falling evenly; none: constant [1]"
    )
    ki: float = Field(default=0.0, ge=0, description="integral constant Ki; 0: plain [1]")
    leak: float = Field(default=0.9, ge=0, le=1, description="share of the integral that a generation keeps [1]")

    def weights(self) -> Array:
        """Return the inertia of every generation."""
        return np.linspace(
            self.inertia, self.inertia if self.inertia_end is None else self.inertia_end, self.generations
        )


class State(NamedTuple):
    """The nests between two moves, for r replicates of n nests in d dimensions."""

    position: Array
    """Shape (r, n, d)."""
    value: Array
    """Shape (r, n)."""
    best_position: Array
    """Shape (r, d)."""
    best_value: Array
    """Shape (r,)."""
    integral: Array
    """Leaky sum of the distances to the best nest, shape (r, n, d)."""


class Draws(NamedTuple):
    """The random numbers of one generation."""

    levy: Array
    """Levy number times a normal one, shape (r, n, d)."""
    partners: NDArray[np.int64]
    """Two permutations of the nests, shape (r, 2, n)."""
    scale: Array
    """Length of each nest's walk, in [0, 1), shape (r, n)."""
    walks: NDArray[np.bool_]
    """Which coordinates walk, shape (r, n, d)."""


def mantegna_deviation(exponent: float) -> float:
    """Return the deviation of the numerator u in Mantegna's Levy number u / |v|^(1/exponent); 0.6966 for 1.5."""
    above = math.gamma(1.0 + exponent) * math.sin(0.5 * math.pi * exponent)
    below = math.gamma(0.5 * (1.0 + exponent)) * exponent * 2.0 ** (0.5 * (exponent - 1.0))
    return float((above / below) ** (1.0 / exponent))


def draws(settings: Settings, dimensions: int, random: Generators) -> Iterator[Draws]:
    """Yield the numbers of each generation; each replicate draws from its own generator, whatever runs beside it."""
    while True:
        blocks = zip(*(_block(settings, dimensions, generator) for generator in random), strict=True)
        levy, partners, scale, walks = (np.stack(block, axis=1) for block in blocks)
        for row in range(_BLOCK):
            yield Draws(levy[row], partners[row], scale[row], walks[row])


def begin(box: Box, nests: int, random: Generators) -> Array:
    """Return nests uniformly in the box, shape (r, n, d)."""
    share = np.stack([generator.random((nests, len(box.low))) for generator in random])
    position: Array = box.low + share * (box.high - box.low)
    return position


def settled(position: Array, value: Array, integral: Array) -> State:
    """Return the state of nests with their values, the best of each replicate found."""
    best, rows = np.argmin(value, axis=1), np.arange(len(value))
    return State(position, value, position[rows, best], value[rows, best], integral)


def fly(settings: Settings, weight: float, box: Box, state: State, levy: Array) -> tuple[Array, Array]:
    """Return where the Levy flights lead, within the box, and the new integral; both of shape (r, n, d)."""
    error = state.best_position[:, None] - state.position
    integral = settings.leak * state.integral + error
    free = weight * state.position - settings.step_scale * levy * error + settings.ki * integral
    return np.clip(free, box.low, box.high), integral


def walk(box: Box, state: State, drawn: Draws) -> Array:
    """Return where the biased walks lead, X + r H (X_j - X_k), within the box, shape (r, n, d)."""
    rows = np.arange(len(state.value))[:, None]
    first, second = state.position[rows, drawn.partners[:, 0]], state.position[rows, drawn.partners[:, 1]]
    free = state.position + drawn.scale[..., None] * drawn.walks * (first - second)
    return np.clip(free, box.low, box.high)


def keep(state: State, candidate: Array, value: Array) -> State:
    """Return the state with each nest moved to its candidate (r, n, d) where that is no worse."""
    better = value <= state.value
    position = np.where(better[..., None], candidate, state.position)
    return settled(position, np.where(better, value, state.value), state.integral)


def step(settings: Settings, weight: float, box: Box, state: State, drawn: Draws, objective: Objective) -> State:
    """Return the state after one generation: flights, then walks, each with a greedy choice."""
    candidate, integral = fly(settings, weight, box, state, drawn.levy)
    state = keep(state._replace(integral=integral), candidate, _values(objective, candidate))
    candidate = walk(box, state, drawn)
    return keep(state, candidate, _values(objective, candidate))


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator) -> History:
    """Run one search.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : of the search; its number of replicates does not count here.
    rng : where all its random numbers come from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    return run(objective, box, settings, [rng])


def replicate(objective: Objective, box: Box, settings: Settings, seed: int) -> History:
    """Run all replicates together; number i is what `minimise` finds with SeedSequence([seed, i])."""
    return run(objective, box, settings, generators(seed, 0, settings.replicates))


def run(objective: Objective, box: Box, settings: Settings, random: Generators) -> History:
    """Run one search per generator, all advanced together; the objective sees all their nests at once."""
    start = begin(box, settings.nests, random)
    state = settled(start, _values(objective, start), np.zeros_like(start))
    replicates, nests, dimensions = start.shape
    rows = settings.generations + 1
    position, value = np.empty((replicates, rows, dimensions)), np.empty((replicates, rows))
    position[:, 0], value[:, 0] = state.best_position, state.best_value
    numbers = draws(settings, dimensions, random)
    for row, weight in enumerate(settings.weights().tolist(), start=1):
        state = step(settings, weight, box, state, next(numbers), objective)
        position[:, row], value[:, row] = state.best_position, state.best_value
    counted = nests * (1 + 2 * np.arange(rows, dtype=np.int64))
    return History(np.broadcast_to(counted, (replicates, rows)).copy(), position, value)


def _block(settings: Settings, dimensions: int, rng: np.random.Generator) -> tuple[NDArray[np.generic], ...]:
    shape = (_BLOCK, settings.nests, dimensions)
    above, below, factor = rng.standard_normal((3, *shape))
    spread = np.maximum(np.abs(below), _SMALLEST) ** (1.0 / settings.levy_exponent)
    levy = mantegna_deviation(settings.levy_exponent) * above / spread * factor
    order = np.broadcast_to(np.arange(settings.nests), (_BLOCK, 2, settings.nests))
    return levy, rng.permuted(order, axis=-1), rng.random(shape[:-1]), rng.random(shape) < settings.pa


def _values(objective: Objective, position: Array) -> Array:
    values: Array = objective(position.reshape(-1, position.shape[-1])).reshape(position.shape[:-1])
    return values
