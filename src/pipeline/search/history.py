"""What every search hands back: the best so far, for each replicate and iteration."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pipeline.search.box import Box

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


def drive(
    make: Callable[[], Any], objective: Objective, box: Box, generations: int, rng: np.random.Generator
) -> History:
    """Run one search.

    Arguments
    ---------
    make : returns the algorithm.
    objective : positions (n, d) to values (n,).
    box : where to look.
    generations : how many, after the start.
    rng : where the seed of its random numbers comes from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    from pymoo.core.problem import Problem

    recorder = Recorder(objective)

    class Boxed(Problem):  # type: ignore[misc]
        def _evaluate(self, x: Any, out: Any, *args: Any, **kwargs: Any) -> None:
            out["F"] = recorder(x)

    problem = Boxed(n_var=len(box.low), n_obj=1, xl=box.low, xu=box.high)
    algorithm = make()
    algorithm.setup(problem, termination=("n_gen", generations + 1), seed=int(rng.integers(2**31)), verbose=False)
    while algorithm.has_next():
        algorithm.next()
        recorder.mark()
    return recorder.history(generations + 1)
