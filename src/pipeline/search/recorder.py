"""Keeps the course of a search that another library runs: it sees every evaluation and never asks for one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.search.history import History, Objective

Array = NDArray[np.float64]


class Recorder:
    """An objective that remembers how often it was asked and its best answer."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective
        self._best: tuple[Array | None, float] = (None, np.inf)
        self.count = 0
        self._rows: list[tuple[int, Array, float]] = []

    def __call__(self, x: Array) -> Array:
        """Return the values (n,) of positions (n, d)."""
        values = self._objective(np.ascontiguousarray(x))
        self.count += len(values)
        leader = int(np.argmin(values))
        if self._best[0] is None or values[leader] < self._best[1]:
            self._best = (np.array(x[leader], dtype=float), float(values[leader]))
        return values

    def mark(self) -> None:
        """End a row of the history."""
        position, value = self._best
        assert position is not None, "nothing has been evaluated yet"
        self._rows.append((self.count, position, value))

    def history(self, rows: int) -> History:
        """Return the history of one replicate; a search that stopped early stands still in its last rows."""
        kept = (self._rows + self._rows[-1:] * rows)[:rows]
        evaluations, position, value = zip(*kept, strict=True)
        return History(np.array([evaluations], dtype=np.int64), np.array([position]), np.array([value]))
