"""Cuckoo searches side by side on the same random numbers, which take most of the time of a cheap objective."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.search.box import Box, CuckooSettings, History, Objective
from pipeline.search.moves import (
    BLOCK,
    Compiled,
    Course,
    Draws,
    Law,
    Nests,
    advance,
    draws,
    fly_all,
    keep_all,
    walk_all,
)
from pipeline.search.streams import Generators

Array = NDArray[np.float64]
Task = tuple[Objective, Box, CuckooSettings]


def together(tasks: Sequence[Task], random: Generators) -> list[History]:
    """Run several searches on the same random numbers.

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
    count, generations, exponent, dimensions = common[0]
    share = np.stack([generator.random((count, dimensions)) for generator in random])
    searches = [Search(*task, share) for task in tasks]
    # A kernel loses nothing by taking one replicate after the other, whose numbers then stay in the processor's cache.
    at_once = 1 if all(isinstance(objective, Compiled) for objective, _, _ in tasks) else len(random)
    for first in range(0, len(random), at_once):
        blocks = draws(count, dimensions, exponent, random[first : first + at_once])
        for done, drawn in zip(range(0, generations, BLOCK), blocks, strict=False):
            for search in searches:
                search.advance(first, done, drawn)
    return [search.history() for search in searches]


class Search:
    """One search on its way: its nests, and the best of each replicate so far."""

    def __init__(self, objective: Objective, box: Box, settings: CuckooSettings, share: Array) -> None:
        """Evaluate nests in the box, from their places in the unit cube, shape (r, n, d)."""
        self._objective = objective
        self._law = Law(settings.pa, settings.step_scale, settings.ki, settings.leak, box.low, box.high)
        self._weights = settings.weights()
        position = box.low + share * (box.high - box.low)
        value, rows = self._values(position), settings.generations + 1
        self.nests = Nests(position, value, np.zeros_like(position), np.argmin(value, axis=1))
        replicates, _, dimensions = share.shape
        self.course = Course(np.empty((replicates, rows, dimensions)), np.empty((replicates, rows)))
        _note(self.nests, self.course, 0)

    def advance(self, first: int, done: int, drawn: Draws) -> None:
        """Run the generations of a block: flights, then walks, each with a greedy choice.

        Arguments
        ---------
        first : replicate that the drawn numbers begin with.
        done : generations before.
        """
        weights, those = self._weights[done : done + BLOCK], slice(first, first + len(drawn.levy))
        nests, course = self.nests.of(those), Course(*(part[those] for part in self.course))
        if isinstance(self._objective, Compiled):
            own = self._objective
            advance(own.address, own.numbers, self._law, weights, drawn, nests, course, done + 1)
            return
        candidate = np.empty_like(nests.position)
        for g, weight in enumerate(weights):
            fly_all(self._law, weight, drawn, g, nests, candidate)
            keep_all(nests, candidate, self._values(candidate))
            walk_all(self._law, drawn, g, nests, candidate)
            keep_all(nests, candidate, self._values(candidate))
            _note(nests, course, done + 1 + g)

    def history(self) -> History:
        """Return the course with the evaluations it took."""
        replicates, rows = self.course.value.shape
        counted = self.nests.position.shape[1] * (1 + 2 * np.arange(rows, dtype=np.int64))
        return History(np.broadcast_to(counted, (replicates, rows)).copy(), self.course.position, self.course.value)

    def _values(self, position: Array) -> Array:
        values: Array = self._objective(position.reshape(-1, position.shape[-1])).reshape(position.shape[:-1])
        return np.ascontiguousarray(values, dtype=np.float64)


def _note(nests: Nests, course: Course, row: int) -> None:
    each = np.arange(len(nests.leader))
    course.position[:, row] = nests.position[each, nests.leader]
    course.value[:, row] = nests.value[each, nests.leader]
