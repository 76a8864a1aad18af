"""Searches against each other: how soon they arrive, how near they end, and whether the difference is one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.search.effect import Effect, effect, mean_with_interval
from pipeline.search.history import History, iterations_until

Array = NDArray[np.float64]
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
    histories: Mapping[str, History], measures: Mapping[str, Measure], rng: np.random.Generator, resamples: int = 2000
) -> tuple[list[Summary], list[Difference]]:
    """Compare every pair of searches by every measure.

    Arguments
    ---------
    histories : search -> its replicates. Equal seeds give equal starts; the intervals, which take the replicates as
        independent, are then a little too wide.
    measures : name -> what to take from a history, a number per replicate, smaller being better; infinite: never.
    rng : where the bootstrap's resamples come from.
    resamples : how many there are for each interval.
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
        for first, second in itertools.combinations(results, 2):
            larger = effect(results[first], results[second], rng, resamples=resamples)
            differences.append(Difference(first, second, name, larger))
    return summaries, differences
