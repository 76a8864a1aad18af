"""Analysis of variance of a balanced, additive design."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.taguchi.analysis import level_sums

Array = NDArray[np.float64]
Levels = NDArray[np.int64]


class Row(NamedTuple):
    """One line of the table; F and p are NaN where they have no meaning."""

    name: str
    sum_of_squares: float
    degrees_of_freedom: int
    mean_square: float
    f: float
    p: float


class Anova(NamedTuple):
    """The factors one by one, all factors together, the error, the total."""

    factors: tuple[Row, ...]
    model: Row
    error: Row
    total: Row

    @property
    def explained_share(self) -> float:
        """Return R^2, the share of the total sum of squares that the factors explain."""
        return self.model.sum_of_squares / self.total.sum_of_squares

    @property
    def residual_deviation(self) -> float:
        """Return the standard deviation of what the factors leave unexplained."""
        return math.sqrt(self.error.mean_square)

    def rows(self) -> tuple[Row, ...]:
        """Return all lines in order."""
        return (*self.factors, self.model, self.error, self.total)


def anova(names: tuple[str, ...], array: Levels, values: Array) -> Anova:
    """Split the variance of an orthogonal array's results into the factors' parts and the rest.

    Arguments
    ---------
    names : the factors, one per column.
    array : level of each factor in each run, shape (m, k), orthogonal.
    values : a result per run (m,), or replicates (m, n), which then add to the error's degrees of freedom.

    Returns
    -------
    The table; each F is a mean square over that of the error (Montgomery, Design and Analysis of Experiments, ch. 3).
    """
    runs = values[:, None] if values.ndim == 1 else values
    replicates = runs.shape[1]
    results = runs.ravel()
    mean = float(np.mean(results))
    total = float(np.sum((results - mean) ** 2))
    squares, freedoms = [], []
    for sums, column in zip(level_sums(array, np.sum(runs, axis=1)), array.T, strict=True):
        counts = np.bincount(column) * replicates
        squares.append(float(np.sum(counts * (sums / counts - mean) ** 2)))
        freedoms.append(len(sums) - 1)
    explained, spent = sum(squares), sum(freedoms)
    error = _row("error", max(total - explained, 0.0), len(results) - 1 - spent)
    factors = tuple(
        _tested(name, square, freedom, error) for name, square, freedom in zip(names, squares, freedoms, strict=True)
    )
    return Anova(
        factors, _tested("all factors", explained, spent, error), error, _row("total", total, len(results) - 1)
    )


def _row(name: str, square: float, freedom: int) -> Row:
    mean_square = square / freedom if freedom > 0 else math.nan
    return Row(name, square, freedom, mean_square, math.nan, math.nan)


def _tested(name: str, square: float, freedom: int, error: Row) -> Row:
    from scipy.special import fdtrc

    row = _row(name, square, freedom)
    f = row.mean_square / error.mean_square if error.mean_square > 0.0 else math.nan
    p = float(fdtrc(freedom, error.degrees_of_freedom, f)) if math.isfinite(f) else math.nan
    return row._replace(f=f, p=p)
