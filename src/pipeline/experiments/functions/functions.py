"""Functions: the runs on every test function in; their statistics, tests, curves and named numbers out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.functions.numbers import VOCABULARY
from pipeline.experiments.functions.statistics import (
    GENERATIONS,
    RESOLUTION,
    VALUE,
    Contest,
    Ranks,
    Runs,
    Statistics,
    contests,
    ranks,
    speedup,
    statistics,
)
from pipeline.kernel.artefacts import Columns, Inputs, Output
from pipeline.quantity import Quantity
from pipeline.search.algorithms.cuckoo import Settings
from pipeline.search.function_records import FunctionStudy
from pipeline.search.moves import BLOCK, draws
from pipeline.search.streams import generators

Complex = NDArray[np.complex128]


def poles(w: float, kp: float, ki: float) -> Complex:
    """Return both roots of s^2 + (1 - w + Kp) s + Ki = 0, per generation; without the integral the one of the loop."""
    return np.roots([1.0, 1.0 - w + kp, ki] if ki > 0.0 else [1.0, 1.0 - w + kp]).astype(complex)


def is_stable(w: float, kp: float, ki: float) -> bool:
    """Tell whether the loop comes to rest: all coefficients positive (Routh)."""
    return 1.0 - w + kp > 0.0 and ki >= 0.0


def is_ringing(w: float, kp: float, ki: float) -> bool:
    """Tell whether the loop comes to rest in dying oscillations: stable, and the roots a complex pair."""
    return is_stable(w, kp, ki) and (1.0 - w + kp) ** 2 < 4.0 * ki


def steady_state_error(w: float, kp: float, ki: float) -> float:
    """Return the error that stays after a unit step of the reference; NaN where the loop does not come to rest.

    Without the integral it is (1 - w) / (1 - w + Kp): plain search, w = 1, has none, since its X is a sum already.
    """
    if not is_stable(w, kp, ki):
        return np.nan
    return 0.0 if ki > 0.0 else (1.0 - w) / (1.0 - w + kp)


def step_poles(w: float, kp: float, ki: float, leak: float) -> Complex:
    """Return the factors by which the loop shrinks from one generation to the next, as the search takes it.

    The leaky sum is S(t) = leak S(t-1) + e(t), used in the move of the same generation. The loop comes to rest where
    all factors lie within the unit circle, which the continuous equation does not ask for.
    """
    if ki == 0.0:
        return np.array([w - kp], dtype=complex)
    # With the reference at 0: S' = leak S - X and X' = (w - Kp) X + Ki S'.
    loop = np.array([[w - kp - ki, ki * leak], [-1.0, leak]])
    return np.linalg.eigvals(loop).astype(complex)


_OF_A_ROW = ("mean", "deviation", "mean_at_budget", "success_share", "generations", "generations_deviation")
_LOOP_GENERATIONS = 420


def quantities(
    study: FunctionStudy, rows: Sequence[Statistics], tested: Sequence[Contest], ranked: Sequence[Ranks]
) -> list[Quantity]:
    """Return the numbers of a study.

    Arguments
    ---------
    study : as configured.
    rows, tested, ranked : its statistics, tests against plain search, and ranks.
    """
    number = VOCABULARY.quantity
    found = _counts(study, rows)
    for row in rows:
        where = {"search": row.search, "function": row.function, "placement": row.placement}
        found += [number(f"{{search}}_{{function}}_{{placement}}_{name}", getattr(row, name), **where)
                  for name in _OF_A_ROW]  # fmt: skip
    for placement in study.placements:
        here = [row for row in rows if row.placement == placement]
        for search in study.searches(1.0):
            values = _of_search([row for row in here if row.search == search])
            values["rank_at_budget"] = _rank(ranked, placement, "mean_at_budget", search)
            found += _numbers("search", search, placement, values)
            if search in study.variants.searches:
                mean_rank = {"mean_rank": _rank(ranked, placement, "mean", search)}
                found += _numbers("variant", search, placement, mean_rank)
            if search in study.variants.searches and search != study.plain:
                found += _numbers("other", search, placement, _against(here, tested, search, study.plain, placement))
        p = {one.measure: one.p for one in ranked if one.placement == placement}
        for name, measure in (("friedman_p", "mean"), ("friedman_at_budget_p", "mean_at_budget")):
            found.append(number(f"{{placement}}_{name}", p.get(measure, np.nan), placement=placement))
    return found


def loops(study: FunctionStudy, seed: int) -> list[Quantity]:
    """Return how the control loop of each variant behaves if its random gain stood still at its median size.

    Arguments
    ---------
    study : as configured; searches that are no cuckoo search are left out.
    seed : root of the random numbers that the gain is measured from.
    """
    every = study.searches(1.0)
    searches = {name: cast(Settings, every[name]) for name in study.loops()}
    if study.plain not in searches:
        return []
    gains = _gains(searches[study.plain], study.dimensions, seed)
    median, number = float(np.median(np.abs(gains))), VOCABULARY.quantity
    found = [number("{gain}_median", median, gain="kp")]
    found.append(number("{gain}_negative_share", float(np.mean(gains < 0.0)), gain="kp"))
    for name, one in searches.items():
        loop = float(one.weights().mean()), median, one.ki
        found += [
            number("{loop}_loop_error", steady_state_error(*loop), loop=name),
            number("{loop}_loop_stable", is_stable(*loop), loop=name),
            number("{loop}_loop_rings", is_ringing(*loop), loop=name),
            number("{loop}_loop_factor", float(np.abs(step_poles(*loop, one.leak)).max()), loop=name),
        ]
    return found


def _numbers(kind: str, search: str, placement: str, values: dict[str, float]) -> list[Quantity]:
    """Return numbers of a search in a placement; `kind` is the field that its name stands for."""
    return [
        VOCABULARY.quantity(f"{{{kind}}}_{{placement}}_{name}", value, **{kind: search, "placement": placement})
        for name, value in values.items()
    ]


def _counts(study: FunctionStudy, rows: Sequence[Statistics]) -> list[Quantity]:
    values = {
        "functions": len(study.functions),
        "dimensions": study.dimensions,
        "variant_replicates": study.variants.replicates,
        "variant_generations": study.variants.shared["generations"],
        "variant_evaluations": next(row.spent for row in rows if row.search == study.plain),
        "baseline_replicates": study.baselines.replicates if study.baselines else np.nan,
        "budget": min(row.spent for row in rows),
    }
    return [VOCABULARY.quantity(name, value) for name, value in values.items()]


def _of_search(rows: Sequence[Statistics]) -> dict[str, float]:
    return {
        "zeros": sum(row.mean == 0.0 for row in rows),
        "perfect": sum(row.mean < RESOLUTION for row in rows),
        "always_reached": sum(row.success_share == 1.0 for row in rows),
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
        "value_better": sum(test.better for test in mine if test.measure == VALUE),
        "value_worse": sum(test.worse for test in mine if test.measure == VALUE),
        "generations_fewer": sum(test.better for test in mine if test.measure == GENERATIONS),
        "generations_more": sum(test.worse for test in mine if test.measure == GENERATIONS),
    }


def _rank(ranked: Sequence[Ranks], placement: str, measure: str, search: str) -> float:
    for one in ranked:
        if one.placement == placement and one.measure == measure:
            return one.mean_rank[search]
    return np.nan


def _gains(plain: Settings, dimensions: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return many values of Kp, what a flight multiplies the distance to the best nest by."""
    drawn = draws(plain.nests, dimensions, plain.levy_exponent, generators(seed, 0, 1))
    return np.concatenate([-plain.step_scale * next(drawn).levy.ravel() for _ in range(_LOOP_GENERATIONS // BLOCK)])


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Compare the searches over all functions."""
    study = FunctionStudy.model_validate(settings["functions"])
    sources = [f"function_runs/{name}" for name in study.functions]
    raw = _joined([inputs.table(source, "runs") for source in sources])
    runs, variants = list(_runs(raw)), list(study.variants.searches)
    rows, tested = statistics(runs), contests(runs, study.plain, variants)
    ranked = ranks(rows, variants)
    output.write("runs", raw)
    output.write("curves", _joined([inputs.table(source, "curves") for source in sources]))
    output.rows("statistics", rows)
    output.rows("tests", tested)
    output.rows("ranks", _ranks(ranked))
    output.numbers(quantities(study, rows, tested, ranked) + loops(study, int(settings["seed"])))


def _joined(parts: Sequence[Columns]) -> Columns:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


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


def _ranks(ranked: Sequence[Ranks]) -> Iterator[tuple[Any, ...]]:
    for one in ranked:
        yield from ((one.placement, one.measure, name, rank, one.p) for name, rank in one.mean_rank.items())
