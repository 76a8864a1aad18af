"""Functions: the runs on every test function in; their statistics, tests, curves and named numbers out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import quantity, schemas, schemas_functions, tables
from pipeline.search.function_quantities import quantities
from pipeline.search.function_records import FunctionStudy
from pipeline.search.function_statistics import Ranks, contests, ranks, statistics
from pipeline.search.function_study import Runs
from pipeline.search.loop_quantities import quantities as loops


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Compare the searches over all functions."""
    study = FunctionStudy.model_validate(settings["functions"])
    folders = [inputs[f"function_runs/{name}"] for name in study.functions]
    raw = _joined(folders, schemas_functions.FUNCTION_RUNS, "runs.parquet")
    runs, variants = list(_runs(raw)), list(study.variants.searches)
    rows, tested = statistics(runs), contests(runs, study.plain, variants)
    ranked = ranks(rows, variants)
    tables.write(schemas_functions.FUNCTION_RUNS, raw, output / "runs.parquet")
    curves = _joined(folders, schemas_functions.FUNCTION_CURVES, "curves.parquet")
    tables.write(schemas_functions.FUNCTION_CURVES, curves, output / "curves.parquet")
    tables.write(schemas_functions.FUNCTION_STATISTICS, _columns(rows), output / "statistics.parquet")
    tables.write(schemas_functions.FUNCTION_TESTS, _columns(tested), output / "tests.parquet")
    tables.write(schemas_functions.FUNCTION_RANKS, _ranks(ranked), output / "ranks.parquet")
    numbers = quantity.columns(quantities(study, rows, tested, ranked) + loops(study, int(settings["seed"])))
    tables.write(schemas.QUANTITIES, numbers, output / "quantities.parquet")


def _joined(folders: Sequence[Path], table: tables.Table, file: str) -> dict[str, Any]:
    parts = [tables.read(table, folder / file) for folder in folders]
    return {column.name: np.concatenate([part[column.name] for part in parts]) for column in table.columns}


def _runs(columns: Mapping[str, Any]) -> Iterator[Runs]:
    """Yield the runs of each search on each function in each placement, in the order of the table."""
    names = list(zip(columns["function"], columns["placement"], columns["search"], strict=True))
    places: dict[tuple[str, str, str], list[int]] = {}
    for place, name in enumerate(names):
        places.setdefault(name, []).append(place)
    for name, rows in places.items():
        values = {column: columns[column][rows] for column in Runs._fields[3:]}
        for column in ("generations", "evaluations"):
            values[column] = np.where(np.isnan(values[column]), np.inf, values[column])
        yield Runs(*name, **values)


def _columns(rows: Sequence[Any]) -> dict[str, list[Any]]:
    return {name: [getattr(row, name) for row in rows] for name in rows[0]._fields}


def _ranks(ranked: Sequence[Ranks]) -> dict[str, list[Any]]:
    flat = [(one.placement, one.measure, name, rank, one.p) for one in ranked for name, rank in one.mean_rank.items()]
    names = [column.name for column in schemas_functions.FUNCTION_RANKS.columns]
    return {name: [row[place] for row in flat] for place, name in enumerate(names)}
