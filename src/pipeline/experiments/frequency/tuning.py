"""Tuning: a parameter design and the objective in; the design as printed and run anew, and its choice out."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.frequency import tuning_tables
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.optimum import objective_of
from pipeline.objective.records import Problem
from pipeline.published.reference import REFERENCE
from pipeline.quantity import Quantity, Vocabulary
from pipeline.search.algorithms.swarm import Settings
from pipeline.search.tuning import results
from pipeline.taguchi import arrays
from pipeline.taguchi.analysis import Anova, anova, chosen_levels, predicted, rank, run_at
from pipeline.taguchi.arrays import Design, is_orthogonal

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
        choices["published"] = chosen_values(factors, array, values)

    def searched(runs: Levels, replicates: int) -> Array:
        knobs = arrays.factor_values(design, runs)
        return results(objective, swarm, knobs, replicates, design.statistic, seed)

    array, counts = arrays.rows(design), tuple(len(levels) for levels in design.factors.values())
    values = searched(array, design.replicates)
    means, elsewhere = np.mean(values, axis=1), np.nan
    choices["rerun"] = chosen_values(design.factors, array, means)
    whole, agreement = output.empty("factorial"), output.empty("agreement")
    if design.factorial_replicates > 0:
        combinations = arrays.full_factorial(counts)
        factorial = searched(combinations, design.factorial_replicates)
        of_all = np.mean(factorial, axis=1)
        elsewhere = float(of_all[arrays.index_in_factorial(chosen_levels(array, means)[None, :], counts)[0]])
        numbers += best_of_factorial(design.factors, combinations, of_all)
        numbers += [
            rank_in_factorial(name, chosen, design.factors, combinations, of_all) for name, chosen in choices.items()
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
    return quantities(name, factors, array, np.mean(values, axis=1), variance, elsewhere)


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


VOCABULARY = Vocabulary(
    {
        "{of}_chosen_{factor}": ("1", "level of {factor} with the least sum"),
        "{of}_p_{factor}": ("1", "chance of an effect this large if {factor} had none"),
        "{of}_share_{factor}": ("1", "share of the variance that {factor} explains"),
        "{of}_p": ("1", "the same for all factors together"),
        "{of}_explained_share": ("1", "share of the variance the factors explain"),
        "{of}_predicted_mw2_s": ("mW2 s", "expected at the chosen levels"),
        "{of}_chosen_mw2_s": ("mW2 s", "result at the chosen levels"),
        "{of}_chosen_rank": ("1", "its rank among the runs of the array; none where it is not one"),
        "{of}_best_run": ("1", "number of the array's best run"),
        "{of}_best_mw2_s": ("mW2 s", "its result"),
        "{of}_mean_mw2_s": ("mW2 s", "mean over the runs"),
        "{of}_runs": ("1", "runs of the array"),
        "{of}_combinations": ("1", "combinations of all levels"),
        "{of}_unbalanced": ("1", "1 where pairs of levels do not occur alike"),
        "factorial_best_{factor}": ("1", "{factor} of the best combination"),
        "factorial_best_mw2_s": ("mW2 s", "mean result of the best combination"),
        "factorial_rank_of_{of}": ("1", "rank of the levels chosen by {of} among all combinations"),
    }
)
"""The numbers of a parameter design; `of` is `published` or `rerun`, `factor` one of the design's."""


def chosen_values(factors: Mapping[str, Sequence[float]], array: Levels, values: Array) -> dict[str, float]:
    """Return what the level sums choose for each factor.

    Arguments
    ---------
    factors : factor -> its levels.
    array : level of each factor in each run, from 0, shape (m, k).
    values : a result per run, smaller is better, shape (m,).
    """
    levels = chosen_levels(array, values)
    return {name: float(factors[name][level]) for name, level in zip(factors, levels, strict=True)}


def quantities(
    of: str,
    factors: Mapping[str, Sequence[float]],
    array: Levels,
    values: Array,
    variance: Anova,
    elsewhere: float = math.nan,
) -> list[Quantity]:
    """Return the numbers that describe a design and its results.

    Arguments
    ---------
    of : what the names begin with.
    factors, array, values : as for `chosen_values`.
    variance : the analysis of variance.
    elsewhere : result of the chosen combination where it was run beside the array.
    """
    levels = chosen_levels(array, values)
    run = run_at(array, levels)
    chosen = elsewhere if run is None else float(values[run])
    place = math.nan if run is None else float(rank(values, run))
    number = partial(VOCABULARY.quantity, of=of)
    by_sums = chosen_values(factors, array, values)
    return [
        *(number("{of}_chosen_{factor}", value, factor=name) for name, value in by_sums.items()),
        *(number("{of}_p_{factor}", row.p, factor=row.name) for row in variance.factors),
        *(
            number("{of}_share_{factor}", row.sum_of_squares / variance.total.sum_of_squares, factor=row.name)
            for row in variance.factors
        ),
        number("{of}_p", variance.model.p),
        number("{of}_explained_share", variance.explained_share),
        number("{of}_predicted_mw2_s", predicted(array, values, levels)),
        number("{of}_chosen_mw2_s", chosen),
        number("{of}_chosen_rank", place),
        number("{of}_best_run", float(np.argmin(values) + 1)),
        number("{of}_best_mw2_s", float(np.min(values))),
        number("{of}_mean_mw2_s", float(np.mean(values))),
        number("{of}_runs", len(values)),
        number("{of}_combinations", math.prod(map(len, factors.values()))),
        number("{of}_unbalanced", not is_orthogonal(array)),
    ]


def best_of_factorial(factors: Mapping[str, Sequence[float]], combinations: Levels, means: Array) -> list[Quantity]:
    """Return the best combination of a full factorial and its mean result."""
    best, number = int(np.argmin(means)), VOCABULARY.quantity
    levels = zip(factors, combinations[best], strict=True)
    found = [number("factorial_best_{factor}", factors[name][level], factor=name) for name, level in levels]
    return [*found, number("factorial_best_mw2_s", means[best])]


def rank_in_factorial(
    of: str, chosen: Mapping[str, float], factors: Mapping[str, Sequence[float]], combinations: Levels, means: Array
) -> Quantity:
    """Return the rank of a choice among all combinations; NaN where the factorial does not hold it."""
    index = None
    if all(chosen[factor] in factors[factor] for factor in factors):
        index = run_at(combinations, np.array([list(factors[name]).index(chosen[name]) for name in factors]))
    return VOCABULARY.quantity("factorial_rank_of_{of}", math.nan if index is None else rank(means, index), of=of)
