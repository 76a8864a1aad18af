"""The front of charging time and temperature rise, and what changes with the calibration of the battery."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.objective.staging import Charges, charge, excess_of
from pipeline.objective.staging_optimum import Optimum, Problem, best_weighted, fastest
from pipeline.objective.staging_records import FrontSettings, Reading, Weights
from pipeline.quantity import Quantity

Array = NDArray[np.float64]
KEPT: tuple[Reading, ...] = ("peak", "final")


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
    """Return the front that NSGA-II finds (Deb et al. 2002, DOI 10.1109/4235.996017, by pymoo)."""
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
    return _points(charge(problem.grid, np.atleast_2d(result.X)), problem.reading)


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
    for reading in KEPT:
        shares = [gain.saved_share for _, gained in calibrated.values() for gain in gained if gain.reading == reading]
        for end, value in (("least", min(shares, default=np.nan)), ("most", max(shares, default=np.nan))):
            words = f"{end} share of the printed time saved at the same {reading} rise, of all calibrations"
            found.append(Quantity(f"{end}_same_{reading}_share", value, "1", words))
    return found


def _of_front(reading: Reading, evolved: Points, scan: Points, printed: Charges) -> Iterator[Quantity]:
    time, rise = float(printed.time_s[0]), float(printed.rise_k(reading)[0])
    better = (evolved.time_s < time) & (evolved.rise_k < rise)
    above = evolved.rise_k - np.interp(evolved.time_s, scan.time_s, scan.rise_k)
    inside = (evolved.time_s >= scan.time_s[0]) & (evolved.time_s <= scan.time_s[-1])
    at_rise = float(np.interp(-rise, -evolved.rise_k, evolved.time_s))
    words = f"NSGA-II's front of time and {reading} rise"
    yield Quantity(f"{reading}_front_points", float(len(evolved.time_s)), "1", f"charges of {words}")
    yield Quantity(
        f"{reading}_dominating_points", float(better.sum()), "1", f"those faster and cooler than printed, {words}"
    )
    farthest = float(above[inside].max()) if inside.any() else np.nan
    yield Quantity(f"{reading}_farthest_above_scan_k", farthest, "K", f"farthest that {words} lies above the scan")
    yield Quantity(
        f"{reading}_time_less_at_printed_rise_share",
        1.0 - at_rise / time,
        "1",
        f"time saved at the printed rise, {words}",
    )


def _of_calibration(name: str, shown: Charges, gained: list[Gain]) -> Iterator[Quantity]:
    for reading in KEPT:
        yield Quantity(
            f"{name}_printed_{reading}_k", float(shown.rise_k(reading)[0]), "K", f"printed {reading} rise, {name}"
        )
    third = shown.end_k[0, min(2, shown.end_k.shape[1] - 1)]
    yield Quantity(f"{name}_rise_after_stage_3_k", float(third), "K", f"printed rise after the third stage, {name}")
    for gain in gained:
        words = f"with no more than the printed {gain.reading} rise, {name}"
        yield Quantity(f"{name}_same_{gain.reading}_s", gain.optimum.value, "s", f"least charging time {words}")
        yield Quantity(f"{name}_same_{gain.reading}_share", gain.saved_share, "1", f"by how much it is less, {words}")


def _points(found: Charges, reading: Reading) -> Points:
    order = np.argsort(found.time_s, kind="stable")
    return Points(found.time_s[order], found.rise_k(reading)[order])
