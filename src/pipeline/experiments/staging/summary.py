"""What a search for stage currents comes to, as named numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.experiments.staging.optimum import Optimum, Problem, best_weighted, coolest, fastest, random_starts
from pipeline.experiments.staging.records import KEPT, READINGS, Currents, Reading, Weights
from pipeline.experiments.staging.stage_charges import Charges, charge, fitness, value_of
from pipeline.experiments.staging.vocabulary import SEARCHED
from pipeline.quantity import Quantity
from pipeline.search.comparison import effect

PRINTED = "printed"
SOLVER = "local solver"


class Case(NamedTuple):
    """One staged charge: its currents, and why it is there."""

    name: str
    currents_a: Array
    found_by: str
    weights: str | None = None
    reading: Reading | None = None
    agreeing: float = 1.0

    def charged(self, problem: Problem) -> Charges:
        """Return what comes of it."""
        return charge(problem.grid, self.currents_a[None, :])


class Constant(NamedTuple):
    """A constant current and what it comes to."""

    current_a: float
    time_s: float
    peak_k: float
    final_k: float


def best_cases(problem: Problem, weights: Mapping[str, Weights], printed: Array, starts: Array) -> list[Case]:
    """Return the best currents for each weights and reading, and those that keep to what the printed ones come to.

    Arguments
    ---------
    printed : currents [A], (stages,).
    starts : currents the local solver starts from [A], (m, stages).
    """
    shown = charge(problem.grid, printed[None, :])
    cases = []
    for reading in READINGS:
        asked = problem._replace(reading=reading)
        for name, pair in weights.items():
            cases.append(_case(f"{name}_best_{reading}", best_weighted(asked, pair, starts), name, reading))
        rise = float(shown.rise_k(reading)[0])
        cases.append(_case(f"same_{reading}", fastest(asked, rise, starts), None, reading))
        if reading != "positive":
            found = coolest(asked, float(shown.time_s[0]), starts)
            cases.append(_case(f"same_time_{reading}", found, None, reading))
    return cases


def _case(name: str, found: Optimum, weights: str | None, reading: Reading) -> Case:
    return Case(name, found.currents_a, SOLVER, weights, reading, found.agreeing)


def starts_of(problem: Problem, count: int, seed: int) -> Array:
    """Return the random currents that the local solver starts from, (count, stages)."""
    return random_starts(problem, count, np.random.default_rng(np.random.SeedSequence([seed, count])))


def constants(problem: Problem, printed: Array) -> dict[str, Constant]:
    """Return the constant currents that take the time of the printed ones, and those that rise as they do.

    Returns
    -------
    `same_time`, `same_peak` and `same_final` -> constant current, without those that no current in the range meets.
    """
    shown = charge(problem.grid, printed[None, :])
    stages = len(printed)
    span = problem.currents
    charge_as = float(np.sum(problem.grid.charge_as))
    found = {"same_time": charge_as / float(shown.time_s[0])}
    for reading in ("peak", "final"):
        wanted = float(shown.rise_k(reading)[0])

        def excess(current: float, reading: Reading = reading, wanted: float = wanted) -> float:
            return float(charge(problem.grid, np.full((1, stages), current)).rise_k(reading)[0]) - wanted

        if excess(span.low) < 0.0 < excess(span.high):
            found[f"same_{reading}"] = float(brentq(excess, span.low, span.high, xtol=1e-12, rtol=1e-14))
    return {name: _constant(problem, current, stages) for name, current in found.items() if _inside(span, current)}


def _inside(span: Currents, current: float) -> bool:
    return span.low <= current <= span.high


def _constant(problem: Problem, current: float, stages: int) -> Constant:
    come_to = charge(problem.grid, np.full((1, stages), current))
    rises = (float(come_to.rise_k(reading)[0]) for reading in ("peak", "final"))
    return Constant(current, float(come_to.time_s[0]), *rises)


Array = NDArray[np.float64]
Columns = Mapping[str, NDArray[np.generic]]
_HIT = 1e-3
_number = SEARCHED.quantity


class Found(NamedTuple):
    """All that the numbers are taken from."""

    problem: Problem
    printed: Array
    weights: Mapping[str, Weights]
    cases: Mapping[str, Case]
    constants: Mapping[str, Constant]
    runs: Mapping[str, Columns]
    """Search -> its runs at the first weights."""
    use: str
    convex: float
    evaluations: int


def quantities(found: Found, rng: np.random.Generator) -> list[Quantity]:
    """Return every number; `rng` draws the resamples of the intervals."""
    return [*of_printed(found), *_weighted(found), *_kept(found), *of_baselines(found), *_searches(found, rng)]


def of_printed(found: Found) -> Iterator[Quantity]:
    """Yield what the printed currents come to, and the scale of the objective."""
    shown = charge(found.problem.grid, found.printed[None, :])
    scale = found.problem.scale()
    yield _number("printed_time_s", float(shown.time_s[0]))
    for reading in READINGS:
        yield _number("printed_{reading}_k", float(shown.rise_k(reading)[0]), reading=reading)
    for n, rise in enumerate(shown.end_k[0].tolist(), start=1):
        yield _number("printed_rise_after_stage_{stage}_k", rise, stage=n)
    yield _number("printed_peak_v", float(shown.peak_v.max()))
    yield _number("printed_mean_current_a", float(np.sum(found.problem.grid.charge_as)) / float(shown.time_s[0]))
    yield _number("printed_largest_increase_a", increase(found.printed))
    yield _number("printed_stages", len(found.printed))
    yield _number("fastest_s", scale.fastest_s)
    yield _number("slowest_s", scale.slowest_s)
    yield _number("hottest_k", scale.hottest_k)
    yield _number("convex_share", found.convex)
    yield _number("evaluations", found.evaluations)
    yield _number("early_evaluations", found.evaluations // 10)


def _weighted(found: Found) -> Iterator[Quantity]:
    problem = found.problem
    scale, ambient_c = problem.scale(), problem.grid.ambient_k - ZERO_CELSIUS_K
    for name, weights in found.weights.items():
        number = partial(_number, weights=name)
        ours, best = found.cases[name], found.cases[f"{name}_best_{problem.reading}"]
        rows = charge(problem.grid, np.array([found.printed, best.currents_a, ours.currents_a]))
        values = value_of(rows, scale, weights, problem.reading, problem.limits, ambient_c)
        fit = fitness(values)
        yield number("{weights}_printed_value", float(values[0]))
        yield number("{weights}_printed_fitness", float(fit[0]))
        yield number("{weights}_best_value", float(values[1]))
        yield number("{weights}_best_fitness", float(fit[1]))
        yield number("{weights}_agreeing_share", best.agreeing)
        yield number("{weights}_value", float(values[2]))
        yield number("{weights}_time_s", float(rows.time_s[2]))
        for reading in READINGS:
            yield number("{weights}_{reading}_k", float(rows.rise_k(reading)[2]), reading=reading)
        yield number("{weights}_largest_increase_a", increase(ours.currents_a))
        for reading in READINGS:
            come_to = found.cases[f"{name}_best_{reading}"].charged(problem)
            yield number("{weights}_best_{reading}_s", float(come_to.time_s[0]), reading=reading)
            yield number("{weights}_best_{reading}_k", float(come_to.rise_k(reading)[0]), reading=reading)


def _kept(found: Found) -> Iterator[Quantity]:
    printed_s = float(charge(found.problem.grid, found.printed[None, :]).time_s[0])
    for reading in READINGS:
        time = float(found.cases[f"same_{reading}"].charged(found.problem).time_s[0])
        yield _number("same_{reading}_s", time, reading=reading)
        yield _number("same_{reading}_share", 1.0 - time / printed_s, reading=reading)
    for kept in KEPT:
        rise = float(found.cases[f"same_time_{kept}"].charged(found.problem).rise_k(kept)[0])
        yield _number("same_time_{kept}_k", rise, kept=kept)


def of_baselines(found: Found) -> Iterator[Quantity]:
    """Yield the constant currents that the printed ones are held against."""
    nothing = Constant(np.nan, np.nan, np.nan, np.nan)
    same_time = found.constants.get("same_time", nothing)
    yield _number("constant_same_time_a", same_time.current_a)
    yield _number("constant_same_time_peak_k", same_time.peak_k)
    yield _number("constant_same_time_final_k", same_time.final_k)
    for kept in KEPT:
        constant = found.constants.get(f"same_{kept}", nothing)
        yield _number("constant_same_{kept}_a", constant.current_a, kept=kept)
        yield _number("constant_same_{kept}_s", constant.time_s, kept=kept)


def _searches(found: Found, rng: np.random.Generator) -> Iterator[Quantity]:
    first = next(iter(found.weights))
    best = next(q.value for q in _weighted(found) if q.name == f"{first}_best_value")
    yield from of_searches(found, best, rng)


def of_searches(found: Found, best: float, rng: np.random.Generator) -> Iterator[Quantity]:
    """Yield what the searches come to; `best` is the least objective there is, `rng` draws the intervals' resamples."""
    rise = f"{found.problem.reading}_k"
    for name, runs in found.runs.items():
        number = partial(_number, search=name)
        value, early = _column(runs, "value"), _column(runs, "early_value")
        excess, time = value / best - 1.0, _column(runs, "time_s")
        yield number("{search}_value_mean", _mean(value))
        yield number("{search}_value_deviation", _deviation(value))
        yield number("{search}_excess_mean", _mean(excess))
        yield number("{search}_excess_worst", float(excess.max()))
        yield number("{search}_hit_share", _mean(excess <= _HIT))
        yield number("{search}_time_mean_s", _mean(time))
        yield number("{search}_time_deviation_s", _deviation(time))
        yield number("{search}_rise_mean_k", _mean(_column(runs, rise)))
        yield number("{search}_evaluations", float(_column(runs, "evaluations").max()))
        yield number("{search}_replicates", len(value))
        yield number("{search}_early_excess_mean", _mean(early / best - 1.0))
        yield number("{search}_early_time_mean_s", _mean(_column(runs, "early_time_s")))
        yield number("{search}_early_rise_mean_k", _mean(_column(runs, f"early_{rise}")))
    yield from _differences(found, rise, rng)


def _differences(found: Found, rise: str, rng: np.random.Generator) -> Iterator[Quantity]:
    ours = found.runs[found.use]
    for name, runs in found.runs.items():
        if name == found.use:
            continue
        number = partial(_number, use=found.use, other=name)
        for early in ("", "early_"):
            ratio = _mean(_column(ours, f"{early}time_s")) / _mean(_column(runs, f"{early}time_s"))
            less = _mean(_column(ours, early + rise)) - _mean(_column(runs, early + rise))
            yield number(f"{early}time_{{use}}_over_{{other}}", ratio)
            yield number(f"{early}rise_{{use}}_less_{{other}}_k", less)
        chance = effect(_column(ours, "value"), _column(runs, "value"), rng)
        yield number("value_{use}_over_{other}", chance.value)
        yield number("value_{use}_over_{other}_low", chance.low)
        yield number("value_{use}_over_{other}_high", chance.high)


def increase(currents: Sequence[float] | Array) -> float:
    """Return the largest step up between stages [A]; 0 where there is none."""
    return max(0.0, float(np.max(np.diff(currents)))) if len(currents) > 1 else 0.0


def _column(runs: Columns, name: str) -> Array:
    return np.asarray(runs[name], dtype=float)


def _mean(values: NDArray[np.generic]) -> float:
    return float(np.mean(values.astype(float)))


def _deviation(values: Array) -> float:
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
