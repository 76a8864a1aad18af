"""Searches on test functions: all of a study's searches on one function, in every placement."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.search.benchmark_functions import problem
from pipeline.search.function_records import FunctionStudy
from pipeline.search.history import History
from pipeline.search.registry import replicated, replicated_alike

Array = NDArray[np.float64]

_POINTS_OF_A_CURVE = 120


class Runs(NamedTuple):
    """What the replicates of one search came to on one function in one placement; arrays of shape (r,)."""

    function: str
    placement: str
    search: str
    value: Array
    """Best value at the end."""
    value_at_budget: Array
    """Best value when as many evaluations were spent as the shortest search of the study spends."""
    generations: Array
    """Generations until the value was at or below the threshold; infinite: never."""
    evaluations: Array
    """The same in evaluations."""
    spent: Array
    """Evaluations in all."""


class Curve(NamedTuple):
    """How they converged: quantiles over the replicates at some generations, shape (k,) each."""

    function: str
    placement: str
    search: str
    generation: NDArray[np.int64]
    evaluations: Array
    low: Array
    median: Array
    high: Array
    mean: Array


def run(
    study: FunctionStudy, function: str, seed: int, told: Callable[[str], None] = lambda message: None
) -> Iterator[tuple[Runs, Curve]]:
    """Run every search on one function in every placement.

    Arguments
    ---------
    study : what to run.
    function : name of one of its functions.
    seed : root of the random streams; the placements have it in common with all other functions and searches.
    told : is told what is being run.

    Yields
    ------
    The runs of a search and the curve of their convergence.
    """
    problems = {
        placement: problem(function, placement, study.dimensions, study.shift_share, seed)
        for placement in study.placements
    }
    tasks = {
        (placement, name): (one.objective, one.box, settings)
        for placement, one in problems.items()
        for name, settings in study.searches(float(one.box.high[0])).items()
    }
    alike = {key: task for key, task in tasks.items() if key[1] in study.variants.searches}
    told(f"{function}: {', '.join(study.variants.searches)}")
    histories = dict(zip(alike, replicated_alike(list(alike.values()), seed), strict=True))
    for (placement, name), (objective, _, settings) in tasks.items():
        if (placement, name) not in histories:
            told(f"{function}, {placement}: {name}")
            histories[placement, name] = replicated(objective, settings, seed)
    budget = min(int(history.evaluations[:, -1].max()) for history in histories.values())
    for placement, name in tasks:
        history, names = histories[placement, name], (function, placement, name)
        yield _runs(history, study.threshold, budget, names), _curve(history, names)


def _runs(history: History, threshold: float, budget: int, names: tuple[str, str, str]) -> Runs:
    replicates = np.arange(len(history.value))
    reached = history.value <= threshold
    first = np.argmax(reached, axis=1)
    arrived = reached[:, -1]
    affordable = np.maximum(np.sum(history.evaluations <= budget, axis=1) - 1, 0)
    return Runs(
        *names,
        value=history.best_value(),
        value_at_budget=history.value[replicates, affordable],
        generations=np.where(arrived, first.astype(float), np.inf),
        evaluations=np.where(arrived, history.evaluations[replicates, first].astype(float), np.inf),
        spent=history.evaluations[:, -1].astype(float),
    )


def _curve(history: History, names: tuple[str, str, str]) -> Curve:
    last = history.value.shape[1] - 1
    shown = np.unique(np.rint(np.geomspace(1, last + 1, _POINTS_OF_A_CURVE)).astype(np.int64) - 1)
    values = history.value[:, shown]
    low, median, high = np.quantile(values, [0.25, 0.5, 0.75], axis=0)
    return Curve(*names, shown, history.evaluations[:, shown].mean(axis=0), low, median, high, mean=values.mean(axis=0))
