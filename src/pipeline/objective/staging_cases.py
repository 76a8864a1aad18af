"""The staged charges that matter: printed, found, best of all; and constant currents to hold them against."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from pipeline.objective.staging import Charges, charge
from pipeline.objective.staging_optimum import Optimum, Problem, best_weighted, coolest, fastest, random_starts
from pipeline.objective.staging_records import READINGS, Currents, Reading, Weights

Array = NDArray[np.float64]
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
