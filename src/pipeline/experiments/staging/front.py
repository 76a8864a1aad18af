"""Front: the stages and the calibrations of the battery in; the front of time and rise, and what calibration does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery
from pipeline.experiments.staging.optimum import Optimum, Problem, best_weighted, fastest, problem_of
from pipeline.experiments.staging.records import KEPT, FrontSettings, Reading, StagingProblem, Weights
from pipeline.experiments.staging.stage_charges import Charges, charge, excess_of
from pipeline.experiments.staging.summary import starts_of
from pipeline.experiments.staging.vocabulary import FRONT
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.quantity import Quantity

Array = NDArray[np.float64]


class Points(NamedTuple):
    """Charges of a front, from fast to slow: time [s] and rise [K], (n,) each."""

    time_s: Array
    rise_k: Array


class Gain(NamedTuple):
    """How much faster than the printed currents the best are, with no more than the same rise."""

    reading: Reading
    printed_s: float
    rise_k: float
    optimum: Optimum

    @property
    def saved_share(self) -> float:
        """Return by how much the charging time is less [1]."""
        return 1.0 - self.optimum.value / self.printed_s


def evolved(problem: Problem, settings: FrontSettings, seed: int) -> Points:
    """Return the front that NSGA-II finds."""
    return _points(charge(problem.grid, evolved_currents(problem, settings, seed)), problem.reading)


def evolved_currents(problem: Problem, settings: FrontSettings, seed: int) -> Array:
    """Return the currents of NSGA-II's front [A], (n, stages) (Deb et al. 2002, DOI 10.1109/4235.996017, by pymoo)."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem as Asked
    from pymoo.optimize import minimize

    stages = int(problem.grid.stage[-1]) + 1
    scale, ambient_c = problem.scale(), problem.grid.ambient_k - 273.15

    class TimeAndRise(Asked):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(n_var=stages, n_obj=2, n_ieq_constr=1, xl=problem.currents.low, xu=problem.currents.high)

        def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
            found = charge(problem.grid, x)
            out["F"] = np.column_stack(
                [found.time_s / scale.slowest_s, found.rise_k(problem.reading) / scale.hottest_k]
            )
            out["G"] = excess_of(found, problem.limits, ambient_c)[:, None]

    result = minimize(TimeAndRise(), NSGA2(pop_size=settings.population), ("n_gen", settings.generations), seed=seed)
    return np.atleast_2d(np.asarray(result.X, dtype=float))


def scanned(problem: Problem, settings: FrontSettings, starts: Array) -> Points:
    """Return the front as the best charges for weights from nearly time alone to nearly rise alone."""
    shares = np.linspace(0.02, 0.98, settings.weights)
    found = [best_weighted(problem, Weights(time=share, rise=1.0 - share), starts).currents_a for share in shares]
    return _points(charge(problem.grid, np.array(found)), problem.reading)


def gains(problem: Problem, printed: Array, starts: Array) -> list[Gain]:
    """Return by how much the best currents are faster than the printed ones, for each rise that is kept."""
    shown = charge(problem.grid, printed[None, :])
    found = []
    for reading in KEPT:
        rise = float(shown.rise_k(reading)[0])
        optimum = fastest(problem._replace(reading=reading), rise, starts)
        found.append(Gain(reading, float(shown.time_s[0]), rise, optimum))
    return found


def quantities(
    fronts: Mapping[Reading, tuple[Points, Points]],
    printed: Charges,
    calibrated: Mapping[str, tuple[Charges, list[Gain]]],
) -> list[Quantity]:
    """Return the numbers of the front and of the calibrations.

    Arguments
    ---------
    fronts : rise -> what NSGA-II found, and the scan.
    printed : the charge with the printed currents.
    calibrated : calibration -> the charge with the printed currents, and the gains.
    """
    found = [one for reading, pair in fronts.items() for one in _of_front(reading, *pair, printed)]
    found += [one for name, (shown, gained) in calibrated.items() for one in _of_calibration(name, shown, gained)]
    for kept in KEPT:
        shares = [gain.saved_share for _, gained in calibrated.values() for gain in gained if gain.reading == kept]
        for end, value in (("least", min(shares, default=np.nan)), ("most", max(shares, default=np.nan))):
            found.append(FRONT.quantity("{end}_same_{kept}_share", value, end=end, kept=kept))
    return found


def _of_front(kept: Reading, evolved: Points, scan: Points, printed: Charges) -> Iterator[Quantity]:
    number = partial(FRONT.quantity, kept=kept)
    time, rise = float(printed.time_s[0]), float(printed.rise_k(kept)[0])
    better = (evolved.time_s < time) & (evolved.rise_k < rise)
    above = evolved.rise_k - np.interp(evolved.time_s, scan.time_s, scan.rise_k)
    inside = (evolved.time_s >= scan.time_s[0]) & (evolved.time_s <= scan.time_s[-1])
    at_rise = float(np.interp(-rise, -evolved.rise_k, evolved.time_s))
    farthest = float(above[inside].max()) if inside.any() else np.nan
    yield number("{kept}_front_points", len(evolved.time_s))
    yield number("{kept}_dominating_points", float(better.sum()))
    yield number("{kept}_farthest_above_scan_k", farthest)
    yield number("{kept}_time_less_at_printed_rise_share", 1.0 - at_rise / time)


def _of_calibration(name: str, shown: Charges, gained: list[Gain]) -> Iterator[Quantity]:
    number = partial(FRONT.quantity, calibration=name)
    for kept in KEPT:
        yield number("{calibration}_printed_{kept}_k", float(shown.rise_k(kept)[0]), kept=kept)
    third = shown.end_k[0, min(2, shown.end_k.shape[1] - 1)]
    yield number("{calibration}_rise_after_stage_3_k", float(third))
    for gain in gained:
        yield number("{calibration}_same_{kept}_s", gain.optimum.value, kept=gain.reading)
        yield number("{calibration}_same_{kept}_share", gain.saved_share, kept=gain.reading)


def _points(found: Charges, reading: Reading) -> Points:
    order = np.argsort(found.time_s, kind="stable")
    return Points(found.time_s[order], found.rise_k(reading)[order])


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Find the front twice for each rise, and the best currents under each calibration."""
    asked = StagingProblem.model_validate(settings["problem"])
    problem = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    how, seed = FrontSettings.model_validate(settings["front"]), int(settings["seed"])
    starts, printed = starts_of(problem, int(settings["starts"]), seed), np.array(asked.plan.currents_a)
    fronts = {reading: _fronts(problem._replace(reading=reading), how, starts, seed) for reading in KEPT}
    batteries = {item["name"]: Battery.model_validate(item["battery"]) for item in settings["calibrations"]}
    calibrated: dict[str, tuple[Charges, list[Gain]]] = {}
    for name, battery in batteries.items():
        other = problem_of(battery, asked.plan, asked.current_a, asked.rise)
        calibrated[name] = charge(other.grid, printed[None, :]), gains(other, printed, starts)
    output.rows("front", _front(fronts))
    output.rows("calibrations", _calibrations(calibrated))
    output.rows("calibration_stages", _stages(calibrated, printed))
    output.numbers(quantities(fronts, charge(problem.grid, printed[None, :]), calibrated))


def _fronts(problem: Problem, how: FrontSettings, starts: Any, seed: int) -> tuple[Points, Points]:
    return evolved(problem, how, seed), scanned(problem, how, starts[:2])


def _front(fronts: Mapping[Reading, tuple[Points, Points]]) -> Iterator[tuple[Any, ...]]:
    for reading, pair in fronts.items():
        for method, points in zip(("nsga2", "scan"), pair, strict=True):
            for time, rise in zip(points.time_s, points.rise_k, strict=True):
                yield (method, reading, float(time), float(rise))


def _calibrations(calibrated: Mapping[str, tuple[Charges, list[Gain]]]) -> Iterator[tuple[Any, ...]]:
    for name, (_, gained) in calibrated.items():
        for gain in gained:
            best = gain.optimum
            yield (name, gain.reading, gain.printed_s, gain.rise_k, best.value, gain.saved_share, best.agreeing)


def _stages(calibrated: Mapping[str, tuple[Charges, list[Gain]]], printed: Any) -> Iterator[tuple[Any, ...]]:
    for name, (shown, gained) in calibrated.items():
        best = [gain.optimum.currents_a for gain in gained]
        for stage, current in enumerate(printed):
            found = (float(currents[stage]) for currents in best)
            yield (name, stage + 1, float(current), float(shown.end_k[0, stage]), *found)
