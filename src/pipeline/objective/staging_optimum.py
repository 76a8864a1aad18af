"""The best stage currents by a local solver from several starts: what the searches are held against.

Over the stages' times instead of their currents the charging time is a sum and the rise bends upwards (which
`convex_share` tests on random chords). Where it does everywhere, a local minimum is the global one.
Kraft, A software package for sequential quadratic programming (1988), by scipy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.objective.staging import Charges, Limits, Scale, charge, scale_of
from pipeline.objective.staging_grid import Grid
from pipeline.objective.staging_records import Currents, Reading, Weights

Array = NDArray[np.float64]
_STEP = 1e-5
_AGREE = 1e-6


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
    return _best(problem, of_time, of_rise, None, -of_time * scale.fastest_s, starts)


def fastest(problem: Problem, rise_k: float, starts: Array) -> Optimum:
    """Return the currents of the shortest charge whose rise does not exceed a given one."""
    return _best(problem, 1.0, 0.0, rise_k, 0.0, starts)


def coolest(problem: Problem, time_s: float, starts: Array) -> Optimum:
    """Return the currents of the least rise in a given time; its value is the rise [K]."""
    return _best(problem, 0.0, 1.0, None, 0.0, starts, time_s)


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


def _best(
    problem: Problem,
    of_time: float,
    of_rise: float,
    cap_k: float | None,
    constant: float,
    starts: Array,
    within_s: float | None = None,
) -> Optimum:
    found = [_solve(problem, of_time, of_rise, cap_k, start, within_s) for start in starts]
    values = np.array([value for _, value in found])
    best = int(np.argmin(values))
    value = float(values[best])
    if not np.isfinite(value):
        raise ValueError("no start led to currents that keep to every limit; widen the range of the currents")
    share = float(np.mean(values <= value + _AGREE * abs(value)))
    return Optimum(found[best][0], value + constant, share)


def _peaks(found: Charges) -> Array:
    """Return the highest rise of each piece of the grid; where that is its start, the end of the one before, its end.

    A row for each piece, not for each stage: of two maxima of one stage the solver would see only the higher.
    """
    begins = np.concatenate([np.zeros((len(found.end_k), 1)), found.piece_end_k[:, :-1]], axis=1)
    return np.where(found.piece_peak_k > begins, found.piece_peak_k, found.piece_end_k)


def _solve(
    problem: Problem, of_time: float, of_rise: float, cap_k: float | None, start: Array, within_s: float | None
) -> tuple[Array, float]:
    """Run the solver from one start, over the stages' times in units of their shortest, and slacks for the rise."""
    grid, limits = problem.grid, problem.limits
    unit_s = np.bincount(grid.stage, weights=grid.charge_as) / problem.currents.high
    stages, longest = len(unit_s), problem.currents.high / problem.currents.low
    slacks = {"final": 1, "peak": 1, "positive": stages}[problem.reading]
    warmest = limits.temperature_c + ZERO_CELSIUS_K - grid.ambient_k
    whole_s = float(unit_s.sum())

    def charged(times: Array) -> Charges:
        return charge(grid, np.clip(problem.currents.high / times, problem.currents.low, problem.currents.high))

    def limited(times: Array) -> Array:
        found = charged(times)
        rises = {"final": found.end_k[:, -1:], "peak": _peaks(found), "positive": found.stage_rise_k}[problem.reading]
        volts = 10.0 * (limits.voltage_v - found.peak_v)
        return np.concatenate([-rises, volts, warmest - found.peak_k], axis=1)

    count = limited(np.ones((1, stages))).shape[1] - 2 * stages
    lift = np.zeros((count + 2 * stages, slacks))
    lift[:count] = 1.0 if slacks == 1 else np.eye(stages)

    def constraints(x: Array) -> Array:
        return np.asarray(limited(x[None, :stages])[0] + lift @ x[stages:])

    def slopes(x: Array) -> Array:
        # Central differences, all in one population; inside the box at its walls.
        above = np.minimum(x[:stages] + _STEP * x[:stages], longest)
        below = np.maximum(x[:stages] - _STEP * x[:stages], 1.0)
        moved = np.tile(x[:stages], (2 * stages, 1))
        moved[np.arange(stages), np.arange(stages)] = above
        moved[stages + np.arange(stages), np.arange(stages)] = below
        values = limited(moved)
        return np.concatenate([((values[:stages] - values[stages:]) / (above - below)[:, None]).T, lift], axis=1)

    asked = [{"type": "ineq", "fun": constraints, "jac": slopes}]
    gradient = np.concatenate([of_time * unit_s, np.full(slacks, of_rise)])
    if cap_k is not None:
        row = np.concatenate([np.zeros(stages), -np.ones(slacks)])
        asked.append({"type": "ineq", "fun": lambda x: cap_k + row @ x, "jac": lambda x: row})
    if within_s is not None:
        whole = np.concatenate([-unit_s, np.zeros(slacks)]) / whole_s
        asked.append({"type": "ineq", "fun": lambda x: within_s / whole_s + whole @ x, "jac": lambda x: whole})
    unit = float(np.max(np.abs(gradient))) or 1.0
    times = problem.currents.high / start
    rises = -limited(times[None, :])[0, :count]
    begin = np.concatenate([times, [max(0.0, rises.max())] if slacks == 1 else np.maximum(rises, 0.0)])
    result = minimize(
        lambda x: float(gradient @ x) / unit,
        begin,
        jac=lambda x: gradient / unit,
        bounds=[(1.0, longest)] * stages + [(None if problem.reading == "final" else 0.0, None)] * slacks,
        constraints=asked,
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-12},
    )
    currents = np.clip(
        problem.currents.high / result.x[:stages], problem.currents.low, problem.currents.high
    )
    # What the currents come to is charged again: the solver's own slacks may be a little off.
    found = charge(grid, currents[None, :])
    rise = float(found.rise_k(problem.reading)[0])
    fine = (
        (cap_k is None or rise <= cap_k + 1e-7)
        and (within_s is None or found.time_s[0] <= within_s * (1.0 + 1e-9))
        and found.peak_v.max() <= limits.voltage_v + 1e-9
        and found.peak_k.max() <= warmest + 1e-7
    )
    return currents, of_time * float(found.time_s[0]) + of_rise * rise if fine else np.inf
