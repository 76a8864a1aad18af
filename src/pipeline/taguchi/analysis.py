"""What an array's results say: level sums, the levels they choose, signal-to-noise ratio, prediction.

Level numbers count from 0. Smaller results are better.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
