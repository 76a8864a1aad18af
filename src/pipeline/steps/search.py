"""Search: the objective and the searches' settings in; their histories, comparison and the frequency found out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import quantity, schemas, tables
from pipeline.objective.loss import objective_of
from pipeline.objective.records import Problem
from pipeline.search.comparison import Difference, Summary
from pipeline.search.history import History
from pipeline.search.outcome import outcome
from pipeline.search.registry import replicated, settings_from
from pipeline.steps import found

VARIABLE = "frequency_hz"


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Run every search with all its replicates."""
    objective, seed = objective_of(Problem.model_validate(settings["problem"])), int(settings["seed"])
    histories = {
        item["name"]: replicated(objective, settings_from(item["settings"]), seed) for item in settings["searches"]
    }
    for name, history in histories.items():
        columns = _history(history)
        tables.write(schemas.SEARCH_HISTORY, columns, output / f"{name}.history.parquet")
        tables.write(schemas.SEARCH_BEST, _ends(columns, history), output / f"{name}.best.parquet")
    result = outcome(histories, seed)
    tables.write(schemas.SEARCH_STATISTICS, _statistics(result.statistics), output / "statistics.parquet")
    tables.write(schemas.SEARCH_COMPARISON, _comparison(result.differences), output / "comparison.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(result.quantities), output / "quantities.parquet")
    found.write({VARIABLE: result.frequency_hz}, output)


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


def _statistics(rows: list[Summary]) -> dict[str, list[Any]]:
    return {
        "search": [row.search for row in rows],
        "measure": [row.measure for row in rows],
        "mean": [_finite(row.mean.value) for row in rows],
        "mean_low": [_finite(row.mean.low) for row in rows],
        "mean_high": [_finite(row.mean.high) for row in rows],
        "arrived_share": [row.arrived_share for row in rows],
    }


def _comparison(rows: list[Difference]) -> dict[str, list[Any]]:
    return {
        "measure": [row.measure for row in rows],
        "first": [row.first for row in rows],
        "second": [row.second for row in rows],
        "larger": [row.larger.value for row in rows],
        "larger_low": [row.larger.low for row in rows],
        "larger_high": [row.larger.high for row in rows],
    }


def _finite(value: float) -> float:
    return value if np.isfinite(value) else np.nan
