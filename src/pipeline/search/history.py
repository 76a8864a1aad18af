"""What every search hands back: the best so far, for each replicate and iteration."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Objective: TypeAlias = Callable[[Array], Array]
"""A whole population at once: positions (n, d) to values (n,)."""


class History(NamedTuple):
    """The course of r replicates over t rows each; row 0 is what the search began with."""

    evaluations: NDArray[np.int64]
    """Evaluations of the objective so far, shape (r, t)."""
    position: Array
    """Best position so far, shape (r, t, d)."""
    value: Array
    """Its value, shape (r, t); never rises along t."""

    def best_position(self) -> Array:
        """Return where each replicate ended, shape (r, d)."""
        return self.position[:, -1]

    def best_value(self) -> Array:
        """Return the value with which each replicate ended, shape (r,)."""
        return self.value[:, -1]

    def columns(self, variables: Iterable[str]) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
        """Return the history as a table, a row per replicate and iteration, a column per variable."""
        replicates, rows = self.value.shape
        table: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {
            "replicate": np.repeat(np.arange(replicates), rows),
            "iteration": np.tile(np.arange(rows), replicates),
            "evaluations": self.evaluations.ravel(),
        }
        for index, name in enumerate(variables):
            table[name] = self.position[:, :, index].ravel()
        table["value"] = self.value.ravel()
        return table


def joined(histories: list[History]) -> History:
    """Return histories of equally many rows as one, replicate after replicate."""
    return History(*(np.concatenate(parts) for parts in zip(*histories, strict=True)))


def iterations_until(reached: NDArray[np.bool_]) -> Array:
    """Return the first iteration from which on a condition holds to the end.

    Arguments
    ---------
    reached : whether the condition holds, shape (r, t).

    Returns
    -------
    Iteration, shape (r,); infinite where the condition does not hold at the end.
    """
    rows = reached.shape[1]
    held = np.logical_and.accumulate(reached[:, ::-1], axis=1).sum(axis=1)
    return np.where(held > 0, (rows - held).astype(float), np.inf)
