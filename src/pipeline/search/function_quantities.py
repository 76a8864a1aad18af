"""The numbers of a function study by name, as the published statements ask for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.quantity import Quantity
from pipeline.search.function_names import COUNTS, OF_A_PLACEMENT, OF_A_ROW, OF_A_SEARCH, OF_A_VARIANT
from pipeline.search.function_records import FunctionStudy
from pipeline.search.function_statistics import GENERATIONS, RESOLUTION, VALUE, Contest, Ranks, Statistics, speedup


def quantities(
    study: FunctionStudy, rows: Sequence[Statistics], tested: Sequence[Contest], ranked: Sequence[Ranks]
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
        for measure, text in OF_A_ROW.items()
    ]
    for placement in study.placements:
        here = [row for row in rows if row.placement == placement]
        for search in study.searches(1.0):
            values = _of_search([row for row in here if row.search == search])
            values["rank_at_budget"] = _rank(ranked, placement, "mean_at_budget", search)
            texts = dict(OF_A_SEARCH)
            if search in study.variants.searches:
                values["mean_rank"] = _rank(ranked, placement, "mean", search)
                texts["mean_rank"] = OF_A_VARIANT["mean_rank"]
            if search in study.variants.searches and search != study.plain:
                values |= _against(here, tested, search, study.plain, placement)
                texts |= OF_A_VARIANT
            words = {"search": search, "placement": placement}
            found += [
                Quantity(f"{search}_{placement}_{name}", values[name], "1", text.format(**words))
                for name, text in texts.items()
            ]
        p = {one.measure: one.p for one in ranked if one.placement == placement}
        for name, measure in (("friedman_p", "mean"), ("friedman_at_budget_p", "mean_at_budget")):
            text = OF_A_PLACEMENT[name].format(placement=placement)
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
    return [Quantity(name, float(values[name]), "1", text) for name, text in COUNTS.items()]


def _of_search(rows: Sequence[Statistics]) -> dict[str, float]:
    return {
        "zeros": float(sum(row.mean == 0.0 for row in rows)),
        "perfect": float(sum(row.mean < RESOLUTION for row in rows)),
        "always_reached": float(sum(row.success_share == 1.0 for row in rows)),
        "mean_success_share": float(np.mean([row.success_share for row in rows])),
    }


def _against(
    rows: Sequence[Statistics], tested: Sequence[Contest], search: str, plain: str, placement: str
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
