"""What a parameter design comes to, as named numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.quantity import Quantity
from pipeline.taguchi.analysis import Anova, chosen_levels, predicted, rank, run_at
from pipeline.taguchi.arrays import is_orthogonal

Array = NDArray[np.float64]
Levels = NDArray[np.int64]

RESULT = "mW2 s"


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
    found = [
        Quantity(f"{of}_chosen_{name}", value, "1", f"level of {name} with the least sum")
        for name, value in chosen_values(factors, array, values).items()
    ]
    found += [
        Quantity(f"{of}_p_{row.name}", row.p, "1", f"chance of an effect this large if {row.name} had none")
        for row in variance.factors
    ]
    return [
        *found,
        Quantity(f"{of}_p", variance.model.p, "1", "the same for all factors together"),
        Quantity(f"{of}_explained_share", variance.explained_share, "1", "share of the variance the factors explain"),
        Quantity(f"{of}_predicted_mw2_s", predicted(array, values, levels), RESULT, "expected at the chosen levels"),
        Quantity(f"{of}_chosen_mw2_s", chosen, RESULT, "result at the chosen levels"),
        Quantity(f"{of}_chosen_rank", place, "1", "its rank among the runs of the array; none where it is not one"),
        Quantity(f"{of}_best_run", float(np.argmin(values) + 1), "1", "number of the array's best run"),
        Quantity(f"{of}_best_mw2_s", float(np.min(values)), RESULT, "its result"),
        Quantity(f"{of}_mean_mw2_s", float(np.mean(values)), RESULT, "mean over the runs"),
        Quantity(f"{of}_runs", float(len(values)), "1", "runs of the array"),
        Quantity(f"{of}_combinations", float(math.prod(map(len, factors.values()))), "1", "combinations of all levels"),
        Quantity(
            f"{of}_unbalanced", float(not is_orthogonal(array)), "1", "1 where pairs of levels do not occur alike"
        ),
    ]


def best_of_factorial(factors: Mapping[str, Sequence[float]], combinations: Levels, means: Array) -> list[Quantity]:
    """Return the best combination of a full factorial and its mean result."""
    best = int(np.argmin(means))
    return [
        *(
            Quantity(f"factorial_best_{name}", float(factors[name][level]), "1", f"{name} of the best combination")
            for name, level in zip(factors, combinations[best], strict=True)
        ),
        Quantity("factorial_best_mw2_s", float(means[best]), RESULT, "mean result of the best combination"),
    ]


def rank_in_factorial(
    of: str, chosen: Mapping[str, float], factors: Mapping[str, Sequence[float]], combinations: Levels, means: Array
) -> Quantity:
    """Return the rank of a choice among all combinations; NaN where the factorial does not hold it."""
    says = f"rank of the levels chosen by {of} among all combinations"
    name = f"factorial_rank_of_{of}"
    if any(chosen[factor] not in factors[factor] for factor in factors):
        return Quantity(name, math.nan, "1", says)
    levels = np.array([list(factors[factor]).index(chosen[factor]) for factor in factors])
    index = run_at(combinations, levels)
    return Quantity(name, math.nan if index is None else float(rank(means, index)), "1", says)
