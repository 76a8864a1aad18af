"""Tuning: a parameter design and the objective in; the design as printed and run anew, and its choice out."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.frequency import design_summary, tuning_tables
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.loss import objective_of
from pipeline.objective.records import Problem
from pipeline.published.reference import REFERENCE
from pipeline.quantity import Quantity
from pipeline.search.algorithms.swarm import Settings
from pipeline.search.tuning import results
from pipeline.taguchi import arrays
from pipeline.taguchi.analysis import anova, chosen_levels
from pipeline.taguchi.records import Design

Array = NDArray[np.float64]
Levels = NDArray[np.int64]
Factors = Mapping[str, tuple[float, ...]]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Analyse the printed design, run it anew, and hold its choice against the full factorial's."""
    design = Design.model_validate(settings["design"])
    swarm, seed = Settings.model_validate(settings["swarm"]), int(settings["seed"])
    objective = objective_of(Problem.model_validate(settings["problem"]))
    numbers: list[Quantity] = []
    choices: dict[str, dict[str, float]] = {}
    if design.printed is not None:
        factors, array, values = _printed(REFERENCE / f"{design.printed}.csv", tuple(design.factors))
        numbers += _analyse("published", factors, array, values[:, None], output)
        choices["published"] = design_summary.chosen_values(factors, array, values)

    def searched(runs: Levels, replicates: int) -> Array:
        knobs = arrays.factor_values(design, runs)
        return results(objective, swarm, knobs, replicates, design.statistic, seed)

    array, counts = arrays.rows(design), tuple(len(levels) for levels in design.factors.values())
    values = searched(array, design.replicates)
    means, elsewhere = np.mean(values, axis=1), np.nan
    choices["rerun"] = design_summary.chosen_values(design.factors, array, means)
    whole, agreement = output.empty("factorial"), output.empty("agreement")
    if design.factorial_replicates > 0:
        combinations = arrays.full_factorial(counts)
        factorial = searched(combinations, design.factorial_replicates)
        of_all = np.mean(factorial, axis=1)
        elsewhere = float(of_all[arrays.index_in_factorial(chosen_levels(array, means)[None, :], counts)[0]])
        numbers += design_summary.best_of_factorial(design.factors, combinations, of_all)
        numbers += [
            design_summary.rank_in_factorial(name, chosen, design.factors, combinations, of_all)
            for name, chosen in choices.items()
        ]
        held = arrays.index_in_factorial(array, counts)
        whole = tuning_tables.factorial(design.factors, combinations, factorial, held)
        agreement = tuning_tables.agreements(tuple(design.factors), array, counts, factorial)
    numbers += _analyse("rerun", design.factors, array, values, output, elsewhere)
    output.write("factorial", whole)
    output.write("agreement", agreement)
    output.numbers(numbers)
    output.found(choices["rerun"])


def _analyse(
    name: str, factors: Factors, array: Levels, values: Array, output: Output, elsewhere: float = np.nan
) -> list[Quantity]:
    """Write the tables of one set of results, shape (m, replicates); return its named numbers."""
    variance = anova(tuple(factors), array, values)
    output.write(f"{name}_runs", tuning_tables.runs(factors, array, values))
    output.write(f"{name}_levels", tuning_tables.levels(factors, array, values))
    output.write(f"{name}_sums", tuning_tables.sums(factors, array, values))
    output.write(f"{name}_anova", tuning_tables.variance(variance))
    return design_summary.quantities(name, factors, array, np.mean(values, axis=1), variance, elsewhere)


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
