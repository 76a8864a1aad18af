"""A genetic algorithm over strings of integers, all replicates advanced together as arrays.

Holland's algorithm in the form of Goldberg (1989), with elitism: parents by stochastic universal sampling over ranks
(Baker, Proc. 2nd ICGA (1987) 14), scattered crossover, and mutation that draws a gene anew. It looks in no box of real
variables, so it is none of `search.algorithms`; its history has their form.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pipeline.record import Record
from pipeline.search.box import History
from pipeline.search.streams import Generators

Array = NDArray[np.float64]
Strings = NDArray[np.int64]
StringObjective: TypeAlias = Callable[[Strings], Array]
"""A whole population at once: strings (m, n) to values (m,)."""


# Generations whose random numbers are drawn in one call.
_DRAWN_AT_ONCE = 32


class GeneticSettings(Record):
    """The algorithm's settings; the defaults that the paper does not print are those of its toolbox."""

    population: int = Field(default=20, ge=2, description="strings of a generation [1]")
    crossover: float = Field(default=0.8, ge=0, le=1, description="chance that a child has two parents [1]")
    mutation: float = Field(default=0.1, ge=0, le=1, description="chance that a gene is drawn anew [1]")
    elite: int = Field(default=2, ge=1, description="best strings that go on unchanged [1]")

    @model_validator(mode="after")
    def _has_children(self) -> GeneticSettings:
        if self.elite >= self.population:
            raise ValueError(f"elite is {self.elite}; it must lie below population, {self.population}")
        return self

    def evaluations(self, generations: int) -> int:
        """Return how many strings are evaluated: the first population, then each generation's children."""
        return self.population + generations * (self.population - self.elite)


class Course(NamedTuple):
    """What came of a search: its history, and the mean value of each population, shape (r, t)."""

    history: History
    mean: Array

    def strings(self) -> Strings:
        """Return where each replicate ended, shape (r, n)."""
        return self.history.best_position().astype(np.int64)


class State(NamedTuple):
    """A generation of each replicate, best string first: strings (r, p, n) and their values (r, p)."""

    strings: Strings
    values: Array


def breed(settings: GeneticSettings, letters: int, strings: Strings, rand: Array) -> Strings:
    """Return the children of a generation, shape (r, c, n): all but the elite of the next one.

    The chance to be a parent goes with 1 / sqrt(rank); equally spaced pointers pick all parents, a shuffle pairs them.

    Arguments
    ---------
    letters : genes are integers from 0 to below it.
    strings : the generation, best first, shape (r, p, n).
    rand : numbers in [0, 1), shape (r, numbers(settings, n)).
    """
    replicates, population, length = strings.shape
    shape = (replicates, population - settings.elite, length)
    start, order, cross, swap, mutate, letter = _parts(settings, length, rand)
    share = np.cumsum(1.0 / np.sqrt(np.arange(1, population + 1)))
    pointers = (start + np.arange(order.shape[1])) * (share[-1] / order.shape[1])
    picked = np.minimum(np.searchsorted(share, pointers, side="right"), population - 1)
    picked = np.take_along_axis(picked, np.argsort(order, axis=1), axis=1)
    parents = strings[np.arange(replicates)[:, None], picked]
    from_other = (cross < settings.crossover)[:, :, None] & (swap.reshape(shape) < 0.5)
    child = np.where(from_other, parents[:, shape[1] :], parents[:, : shape[1]])
    return np.where(
        mutate.reshape(shape) < settings.mutation, (letter.reshape(shape) * letters).astype(np.int64), child
    )


def numbers(settings: GeneticSettings, length: int) -> int:
    """Return how many random numbers a replicate needs for a generation."""
    return sum(_lengths(settings, length))


def _lengths(settings: GeneticSettings, length: int) -> tuple[int, ...]:
    children = settings.population - settings.elite
    return (1, 2 * children, children, *(children * length for _ in range(3)))


def _parts(settings: GeneticSettings, length: int, rand: Array) -> list[Array]:
    ends = list(itertools.accumulate(_lengths(settings, length), initial=0))
    return [rand[:, start:end] for start, end in itertools.pairwise(ends)]


def step(settings: GeneticSettings, letters: int, objective: StringObjective, state: State, rand: Array) -> State:
    """Return the next generation: the elite, and the children, all evaluated at once."""
    children = breed(settings, letters, state.strings, rand)
    elite = settings.elite
    values = _evaluated(objective, children)
    strings = np.concatenate([state.strings[:, :elite], children], axis=1)
    return _sorted(strings, np.concatenate([state.values[:, :elite], values], axis=1))


def _evaluated(objective: StringObjective, strings: Strings) -> Array:
    return objective(strings.reshape(-1, strings.shape[2])).reshape(strings.shape[:2])


def _sorted(strings: Strings, values: Array) -> State:
    order = np.argsort(values, axis=1, kind="stable")
    rows = np.arange(len(values))[:, None]
    return State(strings[rows, order], values[rows, order])


def minimise(
    objective: StringObjective,
    letters: int,
    length: int,
    settings: GeneticSettings,
    generations: int,
    random: Generators,
) -> Course:
    """Run one search per generator, all advanced together; the objective sees all their children at once.

    Arguments
    ---------
    objective : strings (m, n) to values (m,).
    letters : genes are integers from 0 to below it.
    length : genes of a string.
    generations : how many follow the first population.
    random : where each replicate's random numbers come from.
    """
    replicates, rows, count = len(random), generations + 1, numbers(settings, length)
    strings = np.stack([generator.integers(letters, size=(settings.population, length)) for generator in random])
    state = _sorted(strings, _evaluated(objective, strings))
    position, value = np.empty((replicates, rows, length)), np.empty((replicates, rows))
    mean = np.empty((replicates, rows))
    drawn = np.empty((replicates, 0, count))
    for row in range(rows):
        if row > 0:
            place = (row - 1) % _DRAWN_AT_ONCE
            if place == 0:
                drawn = np.stack([generator.random((_DRAWN_AT_ONCE, count)) for generator in random])
            state = step(settings, letters, objective, state, drawn[:, place])
        position[:, row], value[:, row] = state.strings[:, 0], state.values[:, 0]
        mean[:, row] = np.mean(state.values, axis=1)
    counted = settings.population + (settings.population - settings.elite) * np.arange(rows, dtype=np.int64)
    return Course(History(np.broadcast_to(counted, (replicates, rows)).copy(), position, value), mean)
