"""The numbers of a function study by name, as the published statements ask for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.quantity import Quantity
from pipeline.search.function_records import FunctionStudy
from pipeline.search.function_statistics import GENERATIONS, VALUE, Ranks, Statistics, Test, speedup

_OF_A_ROW = {
    "mean": "mean of the best values, {search} on {function}, {placement}",
    "deviation": "standard deviation of the best values, {search} on {function}, {placement}",
    "mean_at_budget": "mean of the best values at the shortest search's budget, {search} on {function}, {placement}",
    "success_share": "share of the runs at or below the threshold, {search} on {function}, {placement}",
    "generations": "mean generations to the threshold of those runs, {search} on {function}, {placement}",
    "generations_deviation": "their standard deviation, {search} on {function}, {placement}",
}
_OF_A_SEARCH = {
    "zeros": "functions on which every run of {search} ends at exactly 0, {placement}",
    "always_reached": "functions on which every run of {search} reaches the threshold, {placement}",
    "mean_success_share": "share of all runs of {search} that reach the threshold, {placement}",
    "rank_at_budget": "mean rank of {search} at the shortest search's budget, {placement}; 1 is best",
}
_OF_A_VARIANT = {
    "mean_rank": "mean rank of {search} among the variants, {placement}; 1 is best",
    "speedup": "plain search's generations to the threshold over those of {search}, geometric mean over the functions "
    "that both always solve, {placement}",
    "value_better": "functions on which {search} ends significantly lower than plain search, {placement}",
    "value_worse": "functions on which {search} ends significantly higher than plain search, {placement}",
    "generations_fewer": "functions on which {search} reaches the threshold significantly sooner, {placement}",
    "generations_more": "functions on which {search} reaches the threshold significantly later, {placement}",
}
_OF_A_PLACEMENT = {
    "friedman_p": "chance of ranks of the variants as far apart as these if they did not differ, {placement}",
    "friedman_at_budget_p": "the same for all searches at the shortest search's budget, {placement}",
}
_COUNTS = {
    "functions": "test functions",
    "dimensions": "dimensions of each",
    "variant_replicates": "runs of each variant on each function",
    "variant_evaluations": "evaluations of a variant's run",
    "baseline_replicates": "runs of each baseline on each function",
    "budget": "evaluations of the shortest search's run",
}


def names(study: FunctionStudy) -> set[str]:
    """Return the names of all numbers that a study finds."""
    searches, variants = list(study.searches(1.0)), [name for name in study.variants.searches if name != study.plain]
    found = {
        f"{search}_{function}_{placement}_{measure}"
        for search in searches for function in study.functions for placement in study.placements
        for measure in _OF_A_ROW
    }  # fmt: skip
    for placement in study.placements:
        found |= {f"{search}_{placement}_{measure}" for search in searches for measure in _OF_A_SEARCH}
        found |= {f"{search}_{placement}_{measure}" for search in variants for measure in _OF_A_VARIANT}
        found |= {f"{study.plain}_{placement}_mean_rank"} | {f"{placement}_{measure}" for measure in _OF_A_PLACEMENT}
    return found | set(_COUNTS)


def quantities(
    study: FunctionStudy, rows: Sequence[Statistics], tested: Sequence[Test], ranked: Sequence[Ranks]
) -> list[Quantity]:
    """Return the numbers of a study.

    Arguments
    ---------
    study : as configured.
    rows, tested, ranked : its statistics, tests against plain search, and ranks.
    """
    found = _counts(study, rows)
    found += [
        Quantity(
            f"{row.search}_{row.function}_{row.placement}_{measure}",
            getattr(row, measure),
            "1",
            text.format(search=row.search, function=row.function, placement=row.placement),
        )
        for row in rows
        for measure, text in _OF_A_ROW.items()
    ]
    for placement in study.placements:
        here = [row for row in rows if row.placement == placement]
        for search in study.searches(1.0):
            values = _of_search([row for row in here if row.search == search])
            values["rank_at_budget"] = _rank(ranked, placement, "mean_at_budget", search)
            texts = dict(_OF_A_SEARCH)
            if search in study.variants.searches:
                values["mean_rank"] = _rank(ranked, placement, "mean", search)
                texts["mean_rank"] = _OF_A_VARIANT["mean_rank"]
            if search in study.variants.searches and search != study.plain:
                values |= _against(here, tested, search, study.plain, placement)
                texts |= _OF_A_VARIANT
            words = {"search": search, "placement": placement}
            found += [
                Quantity(f"{search}_{placement}_{name}", values[name], "1", text.format(**words))
                for name, text in texts.items()
            ]
        p = {one.measure: one.p for one in ranked if one.placement == placement}
        for name, measure in (("friedman_p", "mean"), ("friedman_at_budget_p", "mean_at_budget")):
            text = _OF_A_PLACEMENT[name].format(placement=placement)
            found.append(Quantity(f"{placement}_{name}", p.get(measure, np.nan), "1", text))
    return found


def _counts(study: FunctionStudy, rows: Sequence[Statistics]) -> list[Quantity]:
    values = {
        "functions": len(study.functions),
        "dimensions": study.dimensions,
        "variant_replicates": study.variants.replicates,
        "variant_evaluations": next(row.spent for row in rows if row.search == study.plain),
        "baseline_replicates": study.baselines.replicates if study.baselines else np.nan,
        "budget": min(row.spent for row in rows),
    }
    return [Quantity(name, float(values[name]), "1", text) for name, text in _COUNTS.items()]


def _of_search(rows: Sequence[Statistics]) -> dict[str, float]:
    return {
        "zeros": float(sum(row.mean == 0.0 for row in rows)),
        "always_reached": float(sum(row.success_share == 1.0 for row in rows)),
        "mean_success_share": float(np.mean([row.success_share for row in rows])),
    }


def _against(
    rows: Sequence[Statistics], tested: Sequence[Test], search: str, plain: str, placement: str
) -> dict[str, float]:
    own = {row.function: row for row in rows if row.search == search}
    other = {row.function: row for row in rows if row.search == plain}
    mine = [test for test in tested if test.search == search and test.placement == placement]
    return {
        "speedup": speedup(own, other),
        "value_better": float(sum(test.better for test in mine if test.measure == VALUE)),
        "value_worse": float(sum(test.worse for test in mine if test.measure == VALUE)),
        "generations_fewer": float(sum(test.better for test in mine if test.measure == GENERATIONS)),
        "generations_more": float(sum(test.worse for test in mine if test.measure == GENERATIONS)),
    }


def _rank(ranked: Sequence[Ranks], placement: str, measure: str, search: str) -> float:
    for one in ranked:
        if one.placement == placement and one.measure == measure:
            return one.mean_rank[search]
    return np.nan
