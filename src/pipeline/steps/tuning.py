"""Tuning: a parameter design and the objective in; the design as printed and run anew, and its choice out."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import quantity, schemas, tables
from pipeline.objective.loss import objective_of
from pipeline.objective.records import Problem
from pipeline.published.reference import REFERENCE
from pipeline.quantity import Quantity
from pipeline.search.algorithms.swarm import Settings
from pipeline.search.tuning import results
from pipeline.steps import found, tuning_tables
from pipeline.taguchi import arrays, summary
from pipeline.taguchi.analysis import anova, chosen_levels
from pipeline.taguchi.records import Design

Array = NDArray[np.float64]
Levels = NDArray[np.int64]
Factors = Mapping[str, tuple[float, ...]]


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Analyse the printed design, run it anew, and hold its choice against the full factorial's."""
    design = Design.model_validate(settings["design"])
    swarm, seed = Settings.model_validate(settings["swarm"]), int(settings["seed"])
    objective = objective_of(Problem.model_validate(settings["problem"]))
    numbers: list[Quantity] = []
    choices: dict[str, dict[str, float]] = {}
    if design.printed is not None:
        factors, array, values = _printed(REFERENCE / f"{design.printed}.csv", tuple(design.factors))
        numbers += _analyse("published", factors, array, values[:, None], output)
        choices["published"] = summary.chosen_values(factors, array, values)

    def searched(runs: Levels, replicates: int) -> Array:
        knobs = arrays.factor_values(design, runs)
        return results(objective, swarm, knobs, replicates, design.statistic, seed)

    array, counts = arrays.rows(design), tuple(len(levels) for levels in design.factors.values())
    values = searched(array, design.replicates)
    means, elsewhere = np.mean(values, axis=1), np.nan
    choices["rerun"] = summary.chosen_values(design.factors, array, means)
    whole = tuning_tables.nothing(schemas.TUNING_FACTORIAL)
    agreement = tuning_tables.nothing(schemas.TUNING_AGREEMENT)
    if design.factorial_replicates > 0:
        combinations = arrays.full_factorial(counts)
        factorial = searched(combinations, design.factorial_replicates)
        of_all = np.mean(factorial, axis=1)
        elsewhere = float(of_all[arrays.index_in_factorial(chosen_levels(array, means)[None, :], counts)[0]])
        numbers += summary.best_of_factorial(design.factors, combinations, of_all)
        numbers += [
            summary.rank_in_factorial(name, chosen, design.factors, combinations, of_all)
            for name, chosen in choices.items()
        ]
        held = arrays.index_in_factorial(array, counts)
        whole = tuning_tables.factorial(design.factors, combinations, factorial, held)
        agreement = tuning_tables.agreements(tuple(design.factors), array, counts, factorial)
    numbers += _analyse("rerun", design.factors, array, values, output, elsewhere)
    tables.write(schemas.TUNING_FACTORIAL, whole, output / "factorial.parquet")
    tables.write(schemas.TUNING_AGREEMENT, agreement, output / "agreement.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")
    found.write(choices["rerun"], output)


def _analyse(
    name: str, factors: Factors, array: Levels, values: Array, output: Path, elsewhere: float = np.nan
) -> list[Quantity]:
    """Write the tables of one set of results, shape (m, replicates); return its named numbers."""
    variance = anova(tuple(factors), array, values)
    tables.write(schemas.TUNING_RUNS, tuning_tables.runs(factors, array, values), output / f"{name}.runs.parquet")
    tables.write(schemas.TUNING_LEVELS, tuning_tables.levels(factors, array, values), output / f"{name}.levels.parquet")
    tables.write(schemas.TUNING_SUMS, tuning_tables.sums(factors, array, values), output / f"{name}.sums.parquet")
    tables.write(schemas.TUNING_ANOVA, tuning_tables.variance(variance), output / f"{name}.anova.parquet")
    return summary.quantities(name, factors, array, np.mean(values, axis=1), variance, elsewhere)


def _printed(path: Path, names: tuple[str, ...]) -> tuple[Factors, Levels, Array]:
    """Read a paper's runs: the factors' levels in rising order, the array, and a result per run."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    factors, columns = {}, []
    for name in names:
        levels, index = np.unique([float(row[name]) for row in rows], return_inverse=True)
        factors[name] = tuple(levels.tolist())
        columns.append(index)
    return factors, np.stack(columns, axis=1).astype(np.int64), np.array([float(row["ise"]) for row in rows])
