"""Searches against each other: how soon they arrive, how near they end, and whether the difference is one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.search.box import History, iterations_until

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


Measure = Callable[[History], Array]


class Summary(NamedTuple):
    """One measure of one search over its replicates."""

    search: str
    measure: str
    mean: Effect
    """Mean over the replicates that arrived, with its interval."""
    arrived_share: float


class Difference(NamedTuple):
    """One measure of two searches: the chance that the first's is larger."""

    first: str
    second: str
    measure: str
    larger: Effect


def iterations_within(target: float, tolerance: float) -> Measure:
    """Return the measure `iterations until the first variable stays within a tolerance of a target`."""

    def measure(history: History) -> Array:
        return iterations_until(np.abs(history.position[:, :, 0] - target) <= tolerance)

    return measure


def final_distance(target: float) -> Measure:
    """Return the measure `distance of the first variable from a target at the end`."""

    def measure(history: History) -> Array:
        return np.abs(history.best_position()[:, 0] - target)

    return measure


def compare(
    histories: Mapping[str, History],
    measures: Mapping[str, Measure],
    rng: np.random.Generator,
    resamples: int = 2000,
    first_only: bool = False,
) -> tuple[list[Summary], list[Difference]]:
    """Compare every pair of searches by every measure.

    Arguments
    ---------
    histories : search -> its replicates. Equal seeds give equal starts; the intervals, which take the replicates as
        independent, are then a little too wide.
    measures : name -> what to take from a history, a number per replicate, smaller being better; infinite: never.
    rng : where the bootstrap's resamples come from.
    resamples : how many there are for each interval.
    first_only : whether only the first search is compared with the others.
    """
    summaries, differences = [], []
    for name, measure in measures.items():
        results = {search: measure(history) for search, history in histories.items()}
        for search, values in results.items():
            arrived = values[np.isfinite(values)]
            mean = (
                mean_with_interval(arrived, rng, resamples=resamples)
                if len(arrived)
                else Effect(np.inf, np.inf, np.inf)
            )
            summaries.append(Summary(search, name, mean, len(arrived) / len(values)))
        pairs = list(itertools.combinations(results, 2))
        for first, second in pairs[: len(results) - 1] if first_only else pairs:
            larger = effect(results[first], results[second], rng, resamples=resamples)
            differences.append(Difference(first, second, name, larger))
    return summaries, differences
