"""Search: the objective and the searches' settings in; their histories, comparison and the frequency found out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.frequency.outcome import VARIABLE, outcome
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.optimum import objective_of
from pipeline.objective.records import Problem
from pipeline.search.box import History
from pipeline.search.comparison import Difference, Summary
from pipeline.search.registry import replicated, settings_from


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Run every search with all its replicates."""
    objective, seed = objective_of(Problem.model_validate(settings["problem"])), int(settings["seed"])
    histories = {
        item["name"]: replicated(objective, settings_from(item["settings"]), seed) for item in settings["searches"]
    }
    for name, history in histories.items():
        columns = _history(history)
        output.write(f"{name}_history", columns)
        output.write(f"{name}_best", _ends(columns, history))
    result = outcome(histories, seed)
    output.rows("statistics", [_statistics(row) for row in result.statistics])
    output.rows("comparison", [_comparison(row) for row in result.differences])
    output.numbers(result.quantities)
    output.found({VARIABLE: result.frequency_hz})


def _history(history: History) -> dict[str, NDArray[Any]]:
    columns = history.columns([VARIABLE])
    return {
        "replicate": columns["replicate"],
        "iteration": columns["iteration"],
        "evaluations": columns["evaluations"],
        "variable": np.full(len(columns["value"]), VARIABLE, dtype=object),
        "position": columns[VARIABLE],
        "value": columns["value"],
    }


def _ends(columns: Mapping[str, NDArray[Any]], history: History) -> dict[str, NDArray[Any]]:
    last = columns["iteration"] == history.value.shape[1] - 1
    return {name: column[last] for name, column in columns.items()}


def _statistics(row: Summary) -> tuple[Any, ...]:
    mean = (_finite(row.mean.value), _finite(row.mean.low), _finite(row.mean.high))
    return (row.search, row.measure, *mean, row.arrived_share)


def _comparison(row: Difference) -> tuple[Any, ...]:
    return (row.measure, row.first, row.second, row.larger.value, row.larger.low, row.larger.high)


def _finite(value: float) -> float:
    return value if np.isfinite(value) else np.nan
