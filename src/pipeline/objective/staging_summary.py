"""What a search for stage currents comes to, as named numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.objective.staging import charge, fitness, value_of
from pipeline.objective.staging_cases import Case, Constant
from pipeline.objective.staging_optimum import Problem
from pipeline.objective.staging_records import READINGS, Weights
from pipeline.quantity import Quantity
from pipeline.search.comparison import effect

Array = NDArray[np.float64]
Columns = Mapping[str, NDArray[np.generic]]
_HIT = 1e-3


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
    return [*_printed(found), *_weighted(found), *_kept(found), *_baselines(found), *_searches(found, rng)]


def _printed(found: Found) -> Iterator[Quantity]:
    shown = charge(found.problem.grid, found.printed[None, :])
    scale = found.problem.scale()
    yield Quantity("printed_time_s", float(shown.time_s[0]), "s", "charging time with the printed currents")
    for reading in READINGS:
        rise = float(shown.rise_k(reading)[0])
        yield Quantity(f"printed_{reading}_k", rise, "K", f"their temperature rise, {reading}")
    for n, rise in enumerate(shown.end_k[0].tolist(), start=1):
        yield Quantity(f"printed_rise_after_stage_{n}_k", rise, "K", f"their rise over the ambient after stage {n}")
    yield Quantity("printed_peak_v", float(shown.peak_v.max()), "V", "their highest voltage")
    mean = float(np.sum(found.problem.grid.charge_as)) / float(shown.time_s[0])
    yield Quantity("printed_mean_current_a", mean, "A", "their mean over time")
    yield Quantity("printed_largest_increase_a", _increase(found.printed), "A", "largest step up between stages")
    yield Quantity("printed_stages", float(len(found.printed)), "1", "how many there are")
    yield Quantity("fastest_s", scale.fastest_s, "s", "charging time with every stage at the largest current")
    yield Quantity("slowest_s", scale.slowest_s, "s", "charging time with every stage at the least current")
    yield Quantity("hottest_k", scale.hottest_k, "K", "temperature rise with every stage at the largest current")
    yield Quantity("convex_share", found.convex, "1", "share of random chords below which the rise bends")
    yield Quantity("evaluations", float(found.evaluations), "1", "charges at which the searches are compared")
    yield Quantity("early_evaluations", float(found.evaluations // 10), "1", "a tenth of them")


def _weighted(found: Found) -> Iterator[Quantity]:
    problem = found.problem
    scale, ambient_c = problem.scale(), problem.grid.ambient_k - ZERO_CELSIUS_K
    for name, weights in found.weights.items():
        ours, best = found.cases[name], found.cases[f"{name}_best_{problem.reading}"]
        rows = charge(problem.grid, np.array([found.printed, best.currents_a, ours.currents_a]))
        values = value_of(rows, scale, weights, problem.reading, problem.limits, ambient_c)
        fit = fitness(values)
        yield Quantity(f"{name}_printed_value", float(values[0]), "1", f"objective of the printed currents, {name}")
        yield Quantity(f"{name}_printed_fitness", float(fit[0]), "1", f"their fitness, {name}")
        yield Quantity(f"{name}_best_value", float(values[1]), "1", f"least objective there is, {name}")
        yield Quantity(f"{name}_best_fitness", float(fit[1]), "1", f"its fitness, {name}")
        yield Quantity(
            f"{name}_agreeing_share", best.agreeing, "1", "share of the local solver's starts that end there"
        )
        yield Quantity(f"{name}_value", float(values[2]), "1", f"objective that the search found, {name}")
        yield Quantity(f"{name}_time_s", float(rows.time_s[2]), "s", f"charging time it found, {name}")
        for reading in READINGS:
            rise = float(rows.rise_k(reading)[2])
            yield Quantity(f"{name}_{reading}_k", rise, "K", f"temperature rise it found, {reading}, {name}")
        yield Quantity(f"{name}_largest_increase_a", _increase(ours.currents_a), "A", "largest step up between stages")
        for reading in READINGS:
            case = found.cases[f"{name}_best_{reading}"]
            come_to = case.charged(problem)
            words = f"of the best currents where the rise weighed is the {reading} one, {name}"
            yield Quantity(f"{name}_best_{reading}_s", float(come_to.time_s[0]), "s", f"time {words}")
            yield Quantity(f"{name}_best_{reading}_k", float(come_to.rise_k(reading)[0]), "K", f"that rise {words}")


def _kept(found: Found) -> Iterator[Quantity]:
    printed_s = float(charge(found.problem.grid, found.printed[None, :]).time_s[0])
    for reading in READINGS:
        time = float(found.cases[f"same_{reading}"].charged(found.problem).time_s[0])
        words = f"with no more than the printed currents' {reading} rise"
        yield Quantity(f"same_{reading}_s", time, "s", f"least charging time {words}")
        yield Quantity(f"same_{reading}_share", 1.0 - time / printed_s, "1", f"by how much it is less, {words}")
    for reading in ("peak", "final"):
        rise = float(found.cases[f"same_time_{reading}"].charged(found.problem).rise_k(reading)[0])
        yield Quantity(f"same_time_{reading}_k", rise, "K", f"least {reading} rise in the printed currents' time")


def _baselines(found: Found) -> Iterator[Quantity]:
    nothing = Constant(np.nan, np.nan, np.nan, np.nan)
    time, peak, final = (found.constants.get(name, nothing) for name in ("same_time", "same_peak", "same_final"))
    yield Quantity(
        "constant_same_time_a", time.current_a, "A", "constant current that takes the printed currents' time"
    )
    yield Quantity("constant_same_time_peak_k", time.peak_k, "K", "its highest rise")
    yield Quantity("constant_same_time_final_k", time.final_k, "K", "its final rise")
    for reading, one in (("peak", peak), ("final", final)):
        words = f"constant current with the printed currents' {reading} rise"
        yield Quantity(f"constant_same_{reading}_a", one.current_a, "A", words)
        yield Quantity(f"constant_same_{reading}_s", one.time_s, "s", "its charging time")


def _searches(found: Found, rng: np.random.Generator) -> Iterator[Quantity]:
    first = next(iter(found.weights))
    reading = found.problem.reading
    best = next(q.value for q in _weighted(found) if q.name == f"{first}_best_value")
    rise = f"{reading}_k"
    for name, runs in found.runs.items():
        value, early = _column(runs, "value"), _column(runs, "early_value")
        excess, time = value / best - 1.0, _column(runs, "time_s")
        yield Quantity(f"{name}_value_mean", _mean(value), "1", f"objective that {name} ends with, mean")
        yield Quantity(f"{name}_value_deviation", _deviation(value), "1", "its standard deviation")
        yield Quantity(f"{name}_excess_mean", _mean(excess), "1", f"by how much {name} ends above the least objective")
        yield Quantity(f"{name}_excess_worst", float(excess.max()), "1", "the same of the worst replicate")
        yield Quantity(f"{name}_hit_share", _mean(excess <= _HIT), "1", "share that ends within a thousandth of it")
        yield Quantity(f"{name}_time_mean_s", _mean(time), "s", f"charging time that {name} finds, mean")
        yield Quantity(f"{name}_time_deviation_s", _deviation(time), "s", "its standard deviation")
        yield Quantity(f"{name}_rise_mean_k", _mean(_column(runs, rise)), "K", f"rise that {name} finds, mean")
        yield Quantity(f"{name}_evaluations", float(_column(runs, "evaluations").max()), "1", "charges computed")
        yield Quantity(f"{name}_replicates", float(len(value)), "1", "independent runs")
        words = f"{name} at a tenth of the charges, mean"
        yield Quantity(f"{name}_early_excess_mean", _mean(early / best - 1.0), "1", f"excess of {words}")
        yield Quantity(f"{name}_early_time_mean_s", _mean(_column(runs, "early_time_s")), "s", f"time of {words}")
        yield Quantity(f"{name}_early_rise_mean_k", _mean(_column(runs, f"early_{rise}")), "K", f"rise of {words}")
    yield from _differences(found, rise, rng)


def _differences(found: Found, rise: str, rng: np.random.Generator) -> Iterator[Quantity]:
    ours = found.runs[found.use]
    for name, runs in found.runs.items():
        if name == found.use:
            continue
        for early, words in (("", ""), ("early_", ", at a tenth of the charges")):
            ratio = _mean(_column(ours, f"{early}time_s")) / _mean(_column(runs, f"{early}time_s"))
            less = _mean(_column(ours, early + rise)) - _mean(_column(runs, early + rise))
            pair = f"{found.use} against {name}{words}"
            yield Quantity(f"{early}time_{found.use}_over_{name}", ratio, "1", f"ratio of mean times, {pair}")
            yield Quantity(f"{early}rise_{found.use}_less_{name}_k", less, "K", f"difference of mean rises, {pair}")
        chance = effect(_column(ours, "value"), _column(runs, "value"), rng)
        words = f"chance that {found.use} ends with a larger objective than {name} (Vargha and Delaney's A)"
        pair = f"value_{found.use}_over_{name}"
        yield Quantity(pair, chance.value, "1", words)
        yield Quantity(f"{pair}_low", chance.low, "1", "lower end of its 95 % interval")
        yield Quantity(f"{pair}_high", chance.high, "1", "upper end of its 95 % interval")


def _increase(currents: Sequence[float] | Array) -> float:
    return max(0.0, float(np.max(np.diff(currents)))) if len(currents) > 1 else 0.0


def _column(runs: Columns, name: str) -> Array:
    return np.asarray(runs[name], dtype=float)


def _mean(values: NDArray[np.generic]) -> float:
    return float(np.mean(values.astype(float)))


def _deviation(values: Array) -> float:
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
