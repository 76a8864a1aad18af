"""The best stage currents by a local solver from several starts: what the searches are held against.

Over the stages' times instead of their currents the charging time is a sum and the rise bends upwards (which
`convex_share` tests on random chords). Where it does everywhere, a local minimum is the global one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.objective.staging import Limits, Scale, charge, excess_of, scale_of
from pipeline.objective.staging_grid import Grid
from pipeline.objective.staging_records import Currents, Reading, Weights
from pipeline.objective.staging_solver import Goal, Model, solve

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
