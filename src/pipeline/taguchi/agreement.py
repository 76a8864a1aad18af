"""How often an array's choice is the one the full factorial would make."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.taguchi.analysis import chosen_levels
from pipeline.taguchi.arrays import full_factorial, index_in_factorial

Array = NDArray[np.float64]
Levels = NDArray[np.int64]


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
