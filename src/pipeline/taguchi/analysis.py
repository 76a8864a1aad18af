"""What an array's results say: level sums, the levels they choose, signal-to-noise ratio, prediction, variance.

Level numbers count from 0. Smaller results are better.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.taguchi.arrays import full_factorial, index_in_factorial

Array = NDArray[np.float64]
Levels = NDArray[np.int64]


def level_sums(array: Levels, values: Array) -> list[Array]:
    """Return the sums of the results by factor and level.

    Arguments
    ---------
    array : level of each factor in each run, shape (m, k).
    values : a result per run, shape (m,), or several sets of them, shape (m, n).

    Returns
    -------
    Per factor: sums over the runs at each of its levels, shape (levels,) or (levels, n).
    """
    found = []
    for column in array.T:
        indicator = (column == np.arange(column.max() + 1)[:, None]).astype(float)
        found.append(indicator @ values)
    return found


def chosen_levels(array: Levels, values: Array) -> Levels:
    """Return the level of least sum of each factor, shape (k,), or (n, k) for several sets of results."""
    best = [np.argmin(sums, axis=0) for sums in level_sums(array, values)]
    return np.stack(best, axis=-1).astype(np.int64)


def signal_to_noise_db(values: Array) -> Array:
    """Return the smaller-the-better signal-to-noise ratio of each run, -10 log10 mean(y^2) [dB].

    Arguments
    ---------
    values : results of each run, shape (m,) or with replicates (m, n).
    """
    replicated = values[:, None] if values.ndim == 1 else values
    result: Array = -10.0 * np.log10(np.mean(replicated**2, axis=1))
    return result


def predicted(array: Levels, values: Array, levels: Levels) -> float:
    """Return what the additive model expects at a combination of levels, whether it was run or not.

    Arguments
    ---------
    array, values : the runs (m, k) and a result of each (m,).
    levels : the combination, shape (k,).
    """
    mean = float(np.mean(values))
    at_level = [float(np.mean(values[column == level])) for column, level in zip(array.T, levels, strict=True)]
    return mean + sum(effect - mean for effect in at_level)


def run_at(array: Levels, levels: Levels) -> int | None:
    """Return the number, from 0, of the run at a combination of levels; none where the array does not hold it."""
    found = np.flatnonzero((array == levels).all(axis=1))
    return int(found[0]) if len(found) else None


def rank(values: Array, index: int) -> int:
    """Return the rank of one result among all, 1 for the least."""
    return int(np.sum(values < values[index])) + 1


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


class Agreement(NamedTuple):
    """The array against the factorial, over many repetitions of the whole experiment."""

    searches_per_run: int
    """How many searches the result of a run is the mean of."""
    experiments: int
    """How many times the experiment was repeated, each time with other searches."""
    best: tuple[int, ...]
    """Levels, from 0, of the factorial's best combination, by the mean of all its searches."""
    found_share: float
    """Share of the experiments in which the level sums choose the best combination."""
    factorial_found_share: float
    """The same where all combinations are run instead of the array: what noise leaves to any choice."""
    factor_shares: tuple[float, ...]
    """Share of the experiments in which the array chooses the best combination's level, for each factor."""
    mean_rank: float
    """Mean rank of the chosen combination among all; 1 is the best, (all + 1) / 2 what chance gives."""
    mean_rank_of_best_run: float
    """Mean rank of the array's own best run, the choice without any analysis."""
    mean_regret: float
    """By how much the chosen combination's mean exceeds the best one's, on average."""


def agreement(array: Levels, level_counts: tuple[int, ...], results: Array, searches_per_run: int) -> Agreement:
    """Repeat an array's experiment with the results of a full factorial and compare the choices.

    Each experiment is judged by the searches of all the others, so that it cannot agree with itself.

    Arguments
    ---------
    array : level of each factor in each run, shape (m, k).
    level_counts : number of levels of each factor.
    results : of the full factorial, replicates along the second axis, shape (product of the counts, n).
    searches_per_run : how many replicates one experiment averages over; n // this experiments are made, at least 2.

    Returns
    -------
    The comparison.
    """
    experiments = results.shape[1] // searches_per_run
    if experiments < 2:
        raise ValueError(f"searches_per_run is {searches_per_run}; at most half of {results.shape[1]} are allowed")
    used = results[:, : experiments * searches_per_run]
    sums = used.reshape(len(used), experiments, searches_per_run).sum(axis=2)
    judge = (used.sum(axis=1, keepdims=True) - sums) / (used.shape[1] - searches_per_run)
    ranks = np.argsort(np.argsort(judge, axis=0, kind="stable"), axis=0, kind="stable") + 1
    combinations = full_factorial(level_counts)
    best, each = np.argmin(judge, axis=0), np.arange(experiments)
    runs = index_in_factorial(array, level_counts)
    chosen = chosen_levels(array, sums[runs])
    index = index_in_factorial(chosen, level_counts)
    best_run = runs[np.argmin(sums[runs], axis=0)]
    return Agreement(
        searches_per_run=searches_per_run,
        experiments=experiments,
        best=tuple(int(level) for level in combinations[np.argmin(used.mean(axis=1))]),
        found_share=float(np.mean(index == best)),
        factorial_found_share=float(np.mean(np.argmin(sums, axis=0) == best)),
        factor_shares=tuple(float(share) for share in np.mean(chosen == combinations[best], axis=0)),
        mean_rank=float(np.mean(ranks[index, each])),
        mean_rank_of_best_run=float(np.mean(ranks[best_run, each])),
        mean_regret=float(np.mean(judge[index, each] - judge[best, each])),
    )
