"""The best stage currents by a local solver from several starts: what the searches are held against.

Over the stages' times instead of their currents the charging time is a sum and the rise bends upwards (which
`convex_share` tests on random chords). Where it does everywhere, a local minimum is the global one.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.cell.records import Battery
from pipeline.experiments.staging.kernel import Grid, make_grid
from pipeline.experiments.staging.records import Currents, Plan, Reading, Weights
from pipeline.experiments.staging.stage_charges import Charges, Limits, Scale, charge, excess_of, scale_of

_STEP = 1e-5
_VOLTS = 10.0  # puts volts on the scale of kelvins
_OPTIONS: Any = {"maxiter": 200, "ftol": 1e-12}


class Goal(NamedTuple):
    """What is minimised, `of_time` x time + `of_rise` x rise, and what either may come to."""

    of_time: float
    of_rise: float
    cap_k: float = math.inf
    within_s: float = math.inf


class Model:
    """The constraints over the stages' times, their slopes by central differences, all in one population."""

    def __init__(self, grid: Grid, currents: Currents, reading: Reading, limits: Limits) -> None:
        self._grid, self._currents, self._reading, self._limits = grid, currents, reading, limits
        self.unit_s: Array = np.bincount(grid.stage, weights=grid.charge_as) / currents.high
        self.stages = len(self.unit_s)
        self.longest = currents.high / currents.low
        self._warmest_k = limits.temperature_c + ZERO_CELSIUS_K - grid.ambient_k
        self.slacks = self.stages if reading == "positive" else 1
        self._rises = self._rise(self._charged(np.ones((1, self.stages)))).shape[1]
        self._lift = np.zeros((self._rises + 2 * self.stages, self.slacks))
        self._lift[: self._rises] = 1.0 if self.slacks == 1 else np.eye(self.stages)

    def currents(self, times: Array) -> Array:
        """Return the currents of stage times (n, stages), within their range."""
        return np.clip(self._currents.high / times, self._currents.low, self._currents.high)

    def start(self, currents: Array) -> Array:
        """Return the variables of some currents."""
        times = self._currents.high / currents
        rises = self._rise(self._charged(times[None, :]))[0]
        return np.concatenate([times, [max(0.0, rises.max())] if self.slacks == 1 else np.maximum(rises, 0.0)])

    def bounds(self) -> Any:
        """Return the range of every variable; the rise at the end alone may be negative."""
        lowest = None if self._reading == "final" else 0.0
        return [(1.0, self.longest)] * self.stages + [(lowest, None)] * self.slacks

    def room(self, x: Array) -> Array:
        """Return how far slacks lie above the rises, and voltage and temperature below their limits."""
        return np.asarray(self._limited(x[None, : self.stages])[0] + self._lift @ x[self.stages :])

    def slopes(self, x: Array) -> Array:
        """Return the derivatives of `room`; differences stay inside the box at its walls."""
        times, each = x[: self.stages], np.arange(self.stages)
        above, below = np.minimum(times * (1.0 + _STEP), self.longest), np.maximum(times * (1.0 - _STEP), 1.0)
        moved = np.tile(times, (2 * self.stages, 1))
        moved[each, each], moved[self.stages + each, each] = above, below
        values = self._limited(moved)
        by_time = (values[: self.stages] - values[self.stages :]) / (above - below)[:, None]
        return np.concatenate([by_time.T, self._lift], axis=1)

    def _charged(self, times: Array) -> Charges:
        return charge(self._grid, self.currents(times))

    def _limited(self, times: Array) -> Array:
        found = self._charged(times)
        volts = _VOLTS * (self._limits.voltage_v - found.peak_v)
        return np.concatenate([-self._rise(found), volts, self._warmest_k - found.peak_k], axis=1)

    def _rise(self, found: Charges) -> Array:
        """Return what the slacks must lie above."""
        if self._reading == "final":
            return found.end_k[:, -1:]
        return found.stage_rise_k if self._reading == "positive" else _peaks(found)


def solve(model: Model, goal: Goal, start: Array) -> Array:
    """Return the currents at which the solver ends [A].

    Arguments
    ---------
    start : currents to start from [A], (stages,).
    """
    gradient = np.concatenate([goal.of_time * model.unit_s, np.full(model.slacks, goal.of_rise)])
    gradient /= np.max(np.abs(gradient))
    asked: list[Any] = [{"type": "ineq", "fun": model.room, "jac": model.slopes}]
    if math.isfinite(goal.cap_k):
        asked.append(_at_most(np.concatenate([np.zeros(model.stages), np.ones(model.slacks)]), goal.cap_k))
    if math.isfinite(goal.within_s):
        whole_s = float(model.unit_s.sum())
        times = np.concatenate([model.unit_s / whole_s, np.zeros(model.slacks)])
        asked.append(_at_most(times, goal.within_s / whole_s))

    def wanted(x: Any) -> float:
        return float(gradient @ x)

    def slope(x: Any) -> Any:
        return gradient

    result = minimize(
        wanted,
        model.start(start),
        jac=slope,
        bounds=model.bounds(),
        constraints=asked,
        method="SLSQP",
        options=_OPTIONS,
    )
    return model.currents(result.x[: model.stages])


def _at_most(row: Array, most: float) -> dict[str, Any]:
    return {"type": "ineq", "fun": lambda x: most - row @ x, "jac": lambda x: -row}


def _peaks(found: Charges) -> Array:
    """Return the highest rise of each piece of the grid; where that is its start, the end of the one before, its end.

    A row for each piece, not for each stage: of two maxima of one stage the solver would see only the higher.
    """
    begins = np.concatenate([np.zeros((len(found.end_k), 1)), found.piece_end_k[:, :-1]], axis=1)
    return np.where(found.piece_peak_k > begins, found.piece_peak_k, found.piece_end_k)


Array = NDArray[np.float64]
_AGREE = 1e-6
_SLACK = 1e-7


class Problem(NamedTuple):
    """What is asked: a battery's stages, a range of currents, a reading of the rise, and the limits."""

    grid: Grid
    currents: Currents
    reading: Reading
    limits: Limits

    def scale(self) -> Scale:
        """Return between which values time and rise are normalised."""
        return scale_of(self.grid, self.currents, self.reading)


def problem_of(battery: Battery, plan: Plan, currents: Currents, reading: Reading) -> Problem:
    """Return the stages of a plan with a battery, its limits and a reading of the rise."""
    grid = make_grid(battery, plan.soc_edges, plan.ambient_c, currents.low)
    return Problem(grid, currents, reading, Limits(plan.voltage_v, plan.temperature_c))


class Optimum(NamedTuple):
    """The best found over all starts."""

    currents_a: Array
    """Currents [A], (stages,)."""
    value: float
    """What was minimised: the objective, or the time [s]."""
    agreeing: float
    """Share of the starts that ended within a millionth of it."""


def best_weighted(problem: Problem, weights: Weights, starts: Array) -> Optimum:
    """Return the currents of the least weighted sum of time and rise.

    Arguments
    ---------
    starts : currents to start from [A], (m, stages).
    """
    scale = problem.scale()
    total = weights.time + weights.rise
    of_time = weights.time / total / (scale.slowest_s - scale.fastest_s)
    of_rise = weights.rise / total / scale.hottest_k
    return _best(problem, Goal(of_time, of_rise), -of_time * scale.fastest_s, starts)


def fastest(problem: Problem, rise_k: float, starts: Array) -> Optimum:
    """Return the currents of the shortest charge whose rise does not exceed a given one."""
    return _best(problem, Goal(1.0, 0.0, cap_k=rise_k), 0.0, starts)


def coolest(problem: Problem, time_s: float, starts: Array) -> Optimum:
    """Return the currents of the least rise in a given time; its value is the rise [K]."""
    return _best(problem, Goal(0.0, 1.0, within_s=time_s), 0.0, starts)


def random_starts(problem: Problem, count: int, rng: np.random.Generator) -> Array:
    """Return currents drawn uniformly in their range, (count, stages)."""
    stages = int(problem.grid.stage[-1]) + 1
    return rng.uniform(problem.currents.low, problem.currents.high, (count, stages))


def convex_share(problem: Problem, chords: int, rng: np.random.Generator) -> float:
    """Return the share of random chords, over the stages' times, whose middle does not rise above their ends' mean."""
    ends = [1.0 / random_starts(problem, chords, rng) for _ in range(2)]
    first, second, middle = (
        charge(problem.grid, 1.0 / times).rise_k(problem.reading) for times in (*ends, 0.5 * (ends[0] + ends[1]))
    )
    return float(np.mean(middle <= 0.5 * (first + second) + 1e-12))


def _best(problem: Problem, goal: Goal, constant: float, starts: Array) -> Optimum:
    grid, limits = problem.grid, problem.limits
    model = Model(grid, problem.currents, problem.reading, limits)
    found = []
    for start in starts:
        currents = solve(model, goal, start)
        # What the currents come to is charged again: the solver's own slacks may be a little off.
        come_to = charge(grid, currents[None, :])
        time, rise = float(come_to.time_s[0]), float(come_to.rise_k(problem.reading)[0])
        fine = (
            rise <= goal.cap_k + _SLACK
            and time <= goal.within_s * (1.0 + _SLACK)
            and excess_of(come_to, limits, grid.ambient_k - ZERO_CELSIUS_K)[0] <= _SLACK
        )
        found.append((currents, goal.of_time * time + goal.of_rise * rise if fine else np.inf))
    values = np.array([value for _, value in found])
    best = int(np.argmin(values))
    value = float(values[best])
    if not np.isfinite(value):
        raise ValueError("no start led to currents that keep to every limit; widen the range of the currents")
    share = float(np.mean(values <= value + _AGREE * abs(value)))
    return Optimum(found[best][0], value + constant, share)
