"""Staging search: a battery, its stages, weights and a search in; what its replicates found out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.staging.optimum import problem_of
from pipeline.experiments.staging.records import READINGS, StagingProblem
from pipeline.experiments.staging.stage_charges import Charges, charge, objective_of
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.search.box import History, SearchSettings
from pipeline.search.registry import replicated, settings_from

Array = NDArray[np.float64]
Columns = dict[str, NDArray[np.generic]]
_MOST_ROWS = 150


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Run the search with all its replicates."""
    found = searched(
        StagingProblem.model_validate(settings["problem"]),
        settings_from(settings["search"]),
        int(settings["evaluations"]),
        int(settings["seed"]),
    )
    output.write("runs", found.runs)
    output.write("run_currents", found.currents)
    output.write("course", found.course)


class Searched(NamedTuple):
    """The tables of one search."""

    runs: Columns
    currents: Columns
    course: Columns


def searched(problem: StagingProblem, settings: SearchSettings, evaluations: int, seed: int) -> Searched:
    """Run a search with all its replicates.

    Arguments
    ---------
    evaluations : charges at which the replicates are compared; what a search does beyond them does not count.
    seed : root of the random streams.
    """
    stages = problem_of(problem.battery, problem.plan, problem.current_a, problem.rise)
    objective = objective_of(stages.grid, stages.currents, problem.weights, stages.reading, stages.limits)
    history = replicated(objective, settings, seed)
    early = _at(history, evaluations // 10)
    late = _at(history, evaluations)
    found = charge(stages.grid, late.position[:, -1])
    begun = charge(stages.grid, early.position[:, -1])
    replicates, count = late.position.shape[0], late.position.shape[2]
    runs: Columns = {
        "replicate": np.arange(replicates),
        "evaluations": late.evaluations[:, -1],
        "value": late.value[:, -1],
        **_rises(found),
        "early_evaluations": early.evaluations[:, -1],
        "early_value": early.value[:, -1],
        **{f"early_{name}": column for name, column in _rises(begun).items()},
    }
    currents: Columns = {
        "replicate": np.repeat(np.arange(replicates), count),
        "stage": np.tile(np.arange(1, count + 1), replicates),
        "current_a": late.position[:, -1].ravel(),
    }
    return Searched(runs, currents, _course(late))


def _at(history: History, evaluations: int) -> History:
    """Return a history up to a number of evaluations, at least its first row."""
    rows = max(1, int(np.sum(history.evaluations[0] <= evaluations)))
    return History(history.evaluations[:, :rows], history.position[:, :rows], history.value[:, :rows])


def _rises(found: Charges) -> dict[str, Array]:
    return {"time_s": found.time_s} | {f"{reading}_k": found.rise_k(reading) for reading in READINGS}


def _course(history: History) -> Columns:
    """Return quartiles of the best so far over the replicates, thinned out evenly in the logarithm."""
    rows = history.value.shape[1]
    kept = np.unique(np.rint(np.geomspace(1, rows, min(rows, _MOST_ROWS))).astype(int) - 1)
    low, median, high = np.quantile(history.value[:, kept], (0.25, 0.5, 0.75), axis=0)
    return {"evaluations": history.evaluations[0, kept], "low": low, "median": median, "high": high}
