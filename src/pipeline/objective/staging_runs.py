"""What the replicates of one search for stage currents came to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery
from pipeline.objective.staging import Charges, Limits, charge, objective_of
from pipeline.objective.staging_grid import make_grid
from pipeline.objective.staging_optimum import Problem
from pipeline.objective.staging_records import READINGS, Currents, Plan, Reading, StagingProblem
from pipeline.search.box import SearchSettings
from pipeline.search.history import History
from pipeline.search.registry import replicated

Array = NDArray[np.float64]
Columns = dict[str, NDArray[np.generic]]
_MOST_ROWS = 150


class Searched(NamedTuple):
    """The tables of one search."""

    runs: Columns
    currents: Columns
    course: Columns


def problem_of(battery: Battery, plan: Plan, currents: Currents, reading: Reading) -> Problem:
    """Return the stages of a plan with a battery, its limits and a reading of the rise."""
    grid = make_grid(battery, plan.soc_edges, plan.ambient_c, currents.low)
    return Problem(grid, currents, reading, Limits(plan.voltage_v, plan.temperature_c))


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
