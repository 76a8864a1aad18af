"""The moves of cuckoo search, for all replicates together; `algorithms/cuckoo.py` says what they are and where from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import jit
from pipeline.search.algorithms.cuckoo import Settings
from pipeline.search.box import Box
from pipeline.search.history import History, Objective
from pipeline.search.streams import Generators

Array = NDArray[np.float64]
Task = tuple[Objective, Box, Settings]

_BLOCK = 32  # generations drawn at once; fixed, so that a longer search begins like a shorter one
_SMALLEST = 1e-300


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
    length: Array
    """Length of each nest's walk, in [0, 1), shape (r, n)."""
    chance: Array
    """Uniform number of each coordinate: it walks where that is below pa; shape (r, n, d)."""


def mantegna_deviation(exponent: float) -> float:
    """Return the deviation of the numerator u in Mantegna's Levy number u / |v|^(1/exponent); 0.6966 for 1.5."""
    above = math.gamma(1.0 + exponent) * math.sin(0.5 * math.pi * exponent)
    below = math.gamma(0.5 * (1.0 + exponent)) * exponent * 2.0 ** (0.5 * (exponent - 1.0))
    return float((above / below) ** (1.0 / exponent))


def draws(nests: int, dimensions: int, exponent: float, random: Generators) -> Iterator[Draws]:
    """Yield the numbers of each generation; each replicate draws from its own generator, whatever runs beside it."""
    while True:
        blocks = zip(*(_block(nests, dimensions, exponent, generator) for generator in random), strict=True)
        levy, partners, length, chance = (np.stack(block, axis=1) for block in blocks)
        for row in range(_BLOCK):
            yield Draws(levy[row], partners[row], length[row], chance[row])


def begin(objective: Objective, box: Box, share: Array) -> State:
    """Return evaluated nests in the box, from their places in the unit cube, shape (r, n, d)."""
    position = box.low + share * (box.high - box.low)
    nowhere, worst = np.zeros_like(position), np.full(position.shape[:2], np.inf)
    return State(*keep(nowhere, worst, position, _values(objective, position)), np.zeros_like(position))


def step(settings: Settings, weight: float, box: Box, state: State, drawn: Draws, objective: Objective) -> State:
    """Return the state after one generation: flights, then walks, each with a greedy choice.

    Arguments
    ---------
    settings : of the search; its inertia does not count here.
    weight : the inertia w of this generation [1].
    box : where the nests may be.
    state : before.
    drawn : the generation's random numbers.
    objective : positions (n, d) to values (n,).
    """
    candidate, integral = fly(
        state.position, state.best_position, state.integral, drawn.levy, weight, settings.step_scale, settings.ki,
        settings.leak, box.low, box.high,
    )  # fmt: skip
    position, value, _, _ = keep(state.position, state.value, candidate, _values(objective, candidate))
    candidate = walk(position, drawn.partners, drawn.length, drawn.chance, settings.pa, box.low, box.high)
    return State(*keep(position, value, candidate, _values(objective, candidate)), integral)


@jit
def fly(
    position: Array, best: Array, integral: Array, levy: Array, weight: float, step_scale: float, ki: float,
    leak: float, low: Array, high: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Return where the Levy flights lead, within the box, and the new integral; both of shape (r, n, d)."""
    candidate, summed = np.empty_like(position), np.empty_like(position)
    for r in range(position.shape[0]):
        for n in range(position.shape[1]):
            for d in range(position.shape[2]):
                error = best[r, d] - position[r, n, d]
                summed[r, n, d] = leak * integral[r, n, d] + error
                free = weight * position[r, n, d] - step_scale * levy[r, n, d] * error + ki * summed[r, n, d]
                candidate[r, n, d] = min(max(free, low[d]), high[d])
    return candidate, summed


@jit
def walk(
    position: Array, partners: NDArray[np.int64], length: Array, chance: Array, pa: float, low: Array, high: Array
) -> Array:
    """Return where the biased walks lead, X + length H(pa - chance) (X_j - X_k), within the box, shape (r, n, d)."""
    candidate = np.empty_like(position)
    for r in range(position.shape[0]):
        for n in range(position.shape[1]):
            first, second = partners[r, 0, n], partners[r, 1, n]
            for d in range(position.shape[2]):
                free = position[r, n, d]
                if chance[r, n, d] < pa:
                    free += length[r, n] * (position[r, first, d] - position[r, second, d])
                candidate[r, n, d] = min(max(free, low[d]), high[d])
    return candidate


@jit
def keep(position: Array, value: Array, candidate: Array, found: Array) -> tuple[Array, Array, Array, Array]:
    """Move each nest to its candidate (r, n, d) where what was found there (r, n) is no worse.

    Returns
    -------
    Positions, values, and the best of both for each replicate.
    """
    moved, values = position.copy(), value.copy()
    best, least = np.empty((position.shape[0], position.shape[2])), np.empty(position.shape[0])
    for r in range(position.shape[0]):
        leader = 0
        for n in range(position.shape[1]):
            if found[r, n] <= value[r, n]:
                values[r, n] = found[r, n]
                for d in range(position.shape[2]):
                    moved[r, n, d] = candidate[r, n, d]
            if values[r, n] < values[r, leader]:
                leader = n
        best[r], least[r] = moved[r, leader], values[r, leader]
    return moved, values, best, least


def together(tasks: Sequence[Task], random: Generators) -> list[History]:
    """Run several searches side by side on the same random numbers, which take most of the time of a cheap objective.

    Arguments
    ---------
    tasks : objective, box and settings of each. They have nests, generations, exponent and dimensions in common.
    random : a generator for each replicate.

    Returns
    -------
    The history of each, the same that it has alone.

    Raises
    ------
    ValueError : settings that do not draw alike.
    """
    common = [(one.nests, one.generations, one.levy_exponent, len(box.low)) for _, box, one in tasks]
    if len(set(common)) > 1:
        raise ValueError("searches side by side need the same nests, generations, levy_exponent and dimensions")
    nests, generations, exponent, dimensions = common[0]
    share = np.stack([generator.random((nests, dimensions)) for generator in random])
    states = [begin(objective, box, share) for objective, box, _ in tasks]
    courses = [_Course(state, generations + 1) for state in states]
    weights = [settings.weights().tolist() for _, _, settings in tasks]
    numbers = draws(nests, dimensions, exponent, random)
    for row in range(generations):
        drawn = next(numbers)
        for place, (objective, box, settings) in enumerate(tasks):
            states[place] = step(settings, weights[place][row], box, states[place], drawn, objective)
            courses[place].add(row + 1, states[place])
    counted = nests * (1 + 2 * np.arange(generations + 1, dtype=np.int64))
    evaluations = np.broadcast_to(counted, (len(share), generations + 1))
    return [History(evaluations.copy(), course.position, course.value) for course in courses]


class _Course:
    """The best of each replicate, row by row."""

    def __init__(self, state: State, rows: int) -> None:
        replicates, dimensions = state.best_position.shape
        self.position, self.value = np.empty((replicates, rows, dimensions)), np.empty((replicates, rows))
        self.add(0, state)

    def add(self, row: int, state: State) -> None:
        self.position[:, row], self.value[:, row] = state.best_position, state.best_value


def _block(
    nests: int, dimensions: int, exponent: float, rng: np.random.Generator
) -> tuple[Array, NDArray[np.int64], Array, Array]:
    shape = (_BLOCK, nests, dimensions)
    above, below, factor = rng.standard_normal((3, *shape))
    levy = mantegna_deviation(exponent) * above / np.maximum(np.abs(below), _SMALLEST) ** (1.0 / exponent) * factor
    order = np.broadcast_to(np.arange(nests, dtype=np.int64), (_BLOCK, 2, nests))
    return levy, rng.permuted(order, axis=-1), rng.random(shape[:-1]), rng.random(shape)


def _values(objective: Objective, position: Array) -> Array:
    values: Array = objective(position.reshape(-1, position.shape[-1])).reshape(position.shape[:-1])
    return values
