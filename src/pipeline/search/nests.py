"""Cuckoo searches side by side on the same random numbers, which take most of the time of a cheap objective."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.search.algorithms.cuckoo import Settings
from pipeline.search.box import Box
from pipeline.search.compiled import Compiled
from pipeline.search.history import History, Objective
from pipeline.search.levy import BLOCK, Draws, draws
from pipeline.search.moves import Course, Law, Nests, advance, fly_all, keep_all, walk_all
from pipeline.search.streams import Generators

Array = NDArray[np.float64]
Task = tuple[Objective, Box, Settings]


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
    for done, drawn in zip(range(0, generations, BLOCK), draws(count, dimensions, exponent, random), strict=False):
        for search in searches:
            search.advance(done, drawn)
    return [search.history() for search in searches]


class Search:
    """One search on its way: its nests, and the best of each replicate so far."""

    def __init__(self, objective: Objective, box: Box, settings: Settings, share: Array) -> None:
        """Evaluate nests in the box, from their places in the unit cube, shape (r, n, d)."""
        self._objective = objective
        self._law = Law(settings.pa, settings.step_scale, settings.ki, settings.leak, box.low, box.high)
        self._weights = settings.weights()
        position = box.low + share * (box.high - box.low)
        value, rows = self._values(position), settings.generations + 1
        self.nests = Nests(position, value, np.zeros_like(position), np.argmin(value, axis=1))
        replicates, _, dimensions = share.shape
        self.course = Course(np.empty((replicates, rows, dimensions)), np.empty((replicates, rows)))
        self._note(0)

    def advance(self, done: int, drawn: Draws) -> None:
        """Run the generations of a block: flights, then walks, each with a greedy choice."""
        weights = self._weights[done : done + BLOCK]
        if isinstance(self._objective, Compiled):
            own = self._objective
            advance(own.address, own.numbers, self._law, weights, drawn, self.nests, self.course, done + 1)
            return
        candidate = np.empty_like(self.nests.position)
        for g, weight in enumerate(weights):
            fly_all(self._law, weight, drawn, g, self.nests, candidate)
            keep_all(self.nests, candidate, self._values(candidate))
            walk_all(self._law, drawn, g, self.nests, candidate)
            keep_all(self.nests, candidate, self._values(candidate))
            self._note(done + 1 + g)

    def history(self) -> History:
        """Return the course with the evaluations it took."""
        replicates, rows = self.course.value.shape
        counted = self.nests.position.shape[1] * (1 + 2 * np.arange(rows, dtype=np.int64))
        return History(np.broadcast_to(counted, (replicates, rows)).copy(), self.course.position, self.course.value)

    def _note(self, row: int) -> None:
        each = np.arange(len(self.nests.leader))
        self.course.position[:, row] = self.nests.position[each, self.nests.leader]
        self.course.value[:, row] = self.nests.value[each, self.nests.leader]

    def _values(self, position: Array) -> Array:
        values: Array = self._objective(position.reshape(-1, position.shape[-1])).reshape(position.shape[:-1])
        return np.ascontiguousarray(values, dtype=np.float64)
