"""By how much one search beats another, with its confidence interval."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Effect(NamedTuple):
    """An effect size and the ends of its confidence interval."""

    value: float
    low: float
    high: float


def vargha_delaney(first: ArrayLike, second: ArrayLike) -> float:
    """Return the chance that a result of the first is larger than one of the second, ties counting half.

    0.5 is no difference; Cliff's delta is 2 A - 1 (Vargha and Delaney, J. Educ. Behav. Stat. 25 (2000) 101, DOI
    10.3102/10769986025002101). Infinite results tie with each other and lie above all others.
    """
    above = np.asarray(first, dtype=float)
    order = np.sort(np.asarray(second, dtype=float))
    less = np.searchsorted(order, above, side="left")
    not_more = np.searchsorted(order, above, side="right")
    return float(np.mean(less + not_more) / (2.0 * len(order)))


def effect(
    first: ArrayLike, second: ArrayLike, rng: np.random.Generator, confidence: float = 0.95, resamples: int = 2000
) -> Effect:
    """Return Vargha and Delaney's A with its bootstrap percentile interval.

    Arguments
    ---------
    first, second : results of two searches over independent replicates, shapes (m,) and (n,).
    rng : where the resamples come from.
    confidence : of the interval [1].
    resamples : how many times both are drawn again with replacement.
    """
    one, other = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    order = np.sort(other)
    less = np.searchsorted(order, one, side="left")
    not_more = np.searchsorted(order, one, side="right")
    picked = _picks(rng, len(one), resamples)
    # Share of the second's resample among its first 0, 1, 2, ... results in rising order.
    below = np.pad(np.cumsum(_picks(rng, len(other), resamples), axis=1), ((0, 0), (1, 0)))
    drawn = 0.5 * np.sum(picked * (below[:, less] + below[:, not_more]), axis=1)
    low, high = np.quantile(drawn, [0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence])
    return Effect(vargha_delaney(one, other), float(low), float(high))


def mean_with_interval(
    values: ArrayLike, rng: np.random.Generator, confidence: float = 0.95, resamples: int = 2000
) -> Effect:
    """Return the mean of replicates (m,) with its bootstrap percentile interval."""
    results = np.asarray(values, dtype=float)
    drawn = _picks(rng, len(results), resamples) @ results
    low, high = np.quantile(drawn, [0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence])
    return Effect(float(np.mean(results)), float(low), float(high))


def _picks(rng: np.random.Generator, size: int, resamples: int) -> Array:
    """Return how often each of `size` results is drawn in each resample, as shares, shape (resamples, size)."""
    return rng.multinomial(size, np.full(size, 1.0 / size), size=resamples) / size
