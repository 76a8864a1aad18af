"""How well a fit knows its numbers: covariance, profiles, what is not identified, draws from the fit's distribution.

Residuals of a replay go together over many rows. The information of n rows is therefore taken to be that of the
effective n / (1 + 2 sum rho_k), with the autocorrelation rho of the residuals in the order of the rows, summed up to
where two neighbours of it no longer come to more than nothing (Geyer, Statistical Science 7 (1992) 473).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.own_battery.fitting import Problem, Result, solve
from pipeline.experiments.own_battery.unknowns import Model

Array = NDArray[np.float64]
NORMAL_95 = 1.959963984540054
_AT_BOUND = 1e-3


class Certainty(NamedTuple):
    """What a fit knows.

    Arguments
    ---------
    covariance : of the vector, (d, d).
    low, high : ends of the 95 % intervals of its numbers, logarithms where these count, from profiles where these were
        taken, (d,) each.
    identified : whether a number is known better than before the measurement, (d,).
    rows, effective : rows of voltage that the fit saw, and how many independent ones they are worth.
    """

    covariance: Array
    low: Array
    high: Array
    identified: NDArray[np.bool_]
    rows: int
    effective: float


def inflation(residuals: Array) -> float:
    """Return by how much the variance of a mean of residuals is above that of independent ones, at least 1."""
    count = len(residuals)
    if count < 8 or not np.any(residuals):
        return 1.0
    size = 1 << (2 * count - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(residuals, size)) ** 2
    covariance = np.fft.irfft(spectrum, size)[:count]
    rho = covariance / covariance[0]
    pairs = rho[1 : count - 1 : 2] + rho[2:count:2]
    # Of white residuals the first pair is noise about nothing and stops the sum.
    stop = int(np.argmax(pairs <= 2.0 / math.sqrt(count))) if (pairs <= 2.0 / math.sqrt(count)).any() else len(pairs)
    return float(max(1.0, 1.0 + 2.0 * pairs[:stop].sum()))


def covariance_of(problem: Problem, vector: Array, robust: float) -> tuple[Array, float]:
    """Return the covariance of a vector, and the effective number of rows of voltage.

    A sandwich: bread from the curvature of the loss, filling from the spread of the residuals, each kind of sensor
    inflated by its own autocorrelation; and what the steps of the logger do to rows whose voltage stays within one.
    """
    slopes, missed = problem.slopes(vector), problem.function(vector)
    weight = 1.0 / np.sqrt(1.0 + (missed / robust) ** 2)
    volts, warm = problem.voltages, problem.temperatures
    kinds = [slice(0, volts), slice(volts, volts + warm)]
    bread = slopes.T @ (weight[:, None] * slopes)
    before = slopes[volts + warm :]
    filling = before.T @ before
    effective = float(volts)
    for kind in kinds:
        if kind.stop <= kind.start:
            continue
        scores = weight[kind] * missed[kind]
        factor = inflation(scores)
        spread = float(np.mean(scores**2)) * len(scores) / max(len(scores) - len(vector), 1)
        filling += spread * factor * slopes[kind].T @ slopes[kind]
        effective = min(effective, volts / factor) if kind.start == 0 else effective
    for rows, error in problem.shared(vector):
        together = weight[rows] @ slopes[rows]
        filling += error**2 * np.outer(together, together)
    inverse = _inverse(bread)
    return inverse @ filling @ inverse, effective


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a positive matrix whose scales differ by orders; directions without curvature stay wide."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = np.maximum(values, 1e-13 * values[-1])
    return np.asarray((vectors / kept) @ vectors.T / np.outer(scale, scale))


def _shares(model: Model, vector: Array, spread: Array) -> Array:
    """Return each interval's half-width over that of its prior; without end for a number at a bound."""
    share = NORMAL_95 * np.sqrt(np.maximum(spread, 0.0)) / model.priors()
    low, high = model.bounds()
    reach = _AT_BOUND * (high - low)
    table = np.array([".value." in path for path in model.paths], dtype=bool)
    return np.where(~table & ((vector < low + reach) | (vector > high - reach)), np.inf, share)


def settle(problem: Problem, vector: Array, robust: float) -> tuple[Problem, Result, list[str]]:
    """Let numbers that the measurement does not tell keep their priors, the worst first, and fit the others again.

    Points of tables stay, since each goes with the points beside it; they are only told apart in the end.

    Returns
    -------
    The problem of what is left, its fit, and the key paths of what keeps its prior.
    """
    left: list[str] = []
    result = solve(problem, vector, robust, 20)
    for _ in range(len(vector)):
        covariance, _ = covariance_of(problem, result.vector, robust)
        dropped = _least_known(problem.model, result.vector, covariance)
        if dropped is None:
            break
        left.append(dropped)
        kept = np.array([path != dropped for path in problem.model.paths], dtype=bool)
        evaluations = problem.evaluations
        problem = Problem(problem.model.without([dropped]), problem.parts, problem.spread)
        problem.evaluations = evaluations
        result = solve(problem, result.vector[kept], robust, 10)
    return problem, result, left


def _least_known(model: Model, vector: Array, covariance: Array) -> str | None:
    """Return the number that is known least beside its prior, of those that the measurement leaves near it.

    Only one: with it at its prior the others may be known well, as series resistance is beside a pair too fast to see.
    None where every number is known better than by its prior, or so far from it that the measurement rules it out.
    """
    if not len(vector):
        return None
    share, away = _beside_priors(model, vector, covariance)
    table = np.array([".value." in path for path in model.paths], dtype=bool)
    open_ = ~table & (share >= 1.0) & ((away < NORMAL_95) | np.isinf(share))
    if not open_.any():
        return None
    # The widest first; one at its bound only when no other is left, since another's prior may bring it back.
    return model.paths[int(np.argmax(np.where(open_, np.where(np.isinf(share), 1.0, share), -1.0)))]


def _beside_priors(model: Model, vector: Array, covariance: Array) -> tuple[Array, Array]:
    """Return each interval's half-width over that of its prior, and how far a number is from it, in deviations."""
    mixing = model.mixing()
    spread = np.maximum(np.diag(mixing @ covariance @ mixing.T), 1e-300)
    moved = mixing @ (vector - model.start())
    return _shares(model, vector, spread), np.abs(moved) / np.sqrt(spread)


def certainty_of(problem: Problem, result: Result, robust: float, profiles: int = 12) -> Certainty:
    """Return what a fit knows of its numbers.

    Arguments
    ---------
    profiles : of how many numbers that are no points of tables the interval is taken from a profile, the least certain
        ones first; the others have that of the covariance.
    """
    vector = result.vector
    if not len(vector):
        empty = np.zeros(0)
        return Certainty(np.zeros((0, 0)), empty, empty, empty.astype(bool), problem.voltages, float(problem.voltages))
    covariance, effective = covariance_of(problem, vector, robust)
    mixing = problem.model.mixing()
    spread = np.diag(mixing @ covariance @ mixing.T)
    share, away = _beside_priors(problem.model, vector, covariance)
    table = np.array([".value." in path for path in problem.model.paths], dtype=bool)
    known = (share < 1.0) | (~table & np.isfinite(share) & (away >= NORMAL_95))
    numbers, half = mixing @ vector, NORMAL_95 * np.sqrt(np.maximum(spread, 0.0))
    low, high = numbers - half, numbers + half
    alone = [place for place, path in enumerate(problem.model.paths) if ".value." not in path and known[place]]
    slopes, missed = problem.slopes(vector), problem.function(vector)
    weight = 1.0 / np.sqrt(1.0 + (missed / robust) ** 2)
    base = _Base(vector, covariance, _inverse(slopes.T @ (weight[:, None] * slopes)), _cost(problem, vector, robust))
    for place in sorted(alone, key=lambda one: -share[one])[:profiles]:
        low[place] = vector[place] - _profiled(problem, base, place, -1.0, robust)
        high[place] = vector[place] + _profiled(problem, base, place, 1.0, robust)
    return Certainty(covariance, low, high, known, problem.voltages, effective)


class _Base(NamedTuple):
    """From where profiles start: the best vector, its covariance, the inverse curvature of the loss, the loss."""

    vector: Array
    covariance: Array
    inverse: Array
    cost: float


def _profiled(problem: Problem, base: _Base, place: int, side: float, robust: float) -> float:
    """Return how far a number may go before the loss, the others fitted again, rises by what 95 % allow.

    The rise that is allowed is that which a parabola with the covariance would have there, so that the effective number
    of rows enters; one step of the secant method from there finds where the real rise is the same.
    """
    vector, covariance = base.vector, base.covariance
    deviation = math.sqrt(covariance[place, place])
    bounds = problem.model.bounds()
    goal = side * NORMAL_95 * deviation
    goal = float(np.clip(vector[place] + goal, bounds[0][place], bounds[1][place]) - vector[place])
    others = np.arange(len(vector)) != place
    allowed = 0.5 / base.inverse[place, place] * (NORMAL_95 * deviation) ** 2
    moved = vector + covariance[:, place] / covariance[place, place] * goal
    moved = np.clip(moved, *bounds)
    # The others are fitted again from there, by two steps of Gauss and Newton.
    for _ in range(2):
        slopes, missed = problem.slopes(moved), problem.function(moved)
        weight = 1.0 / np.sqrt(1.0 + (missed / robust) ** 2)
        inner = slopes[:, others]
        step = _inverse(inner.T @ (weight[:, None] * inner)) @ (inner.T @ (weight * missed))
        moved[others] = np.clip(moved[others] - step, bounds[0][others], bounds[1][others])
    rise = _cost(problem, moved, robust) - base.cost
    ratio = math.sqrt(allowed / rise) if rise > 0.0 else 1.0
    return abs(goal) * min(max(ratio, 0.5), 2.0)


def _cost(problem: Problem, vector: Array, robust: float) -> float:
    z = (problem.function(vector) / robust) ** 2
    return float(0.5 * robust**2 * np.sum(2.0 * (np.sqrt(1.0 + z) - 1.0)))


def draws(model: Model, vector: Array, covariance: Array, count: int, rng: np.random.Generator) -> Array:
    """Return the numbers of draws from the fit's normal distribution, in their own units, shape (count, d).

    The numbers are drawn, not the rises between them: cut off at zero, rises would add up. Where a drawn open-circuit
    voltage falls, the points that fall are brought to their mean (isotonic regression).
    """
    from scipy.optimize import isotonic_regression

    if not len(vector):
        return np.zeros((count, 0))
    mixing = model.mixing()
    values, axes = np.linalg.eigh(mixing @ (0.5 * (covariance + covariance.T)) @ mixing.T)
    normal = rng.standard_normal((count, len(vector)))
    found = mixing @ vector + (normal * np.sqrt(np.maximum(values, 0.0))) @ axes.T
    rises = model.rises()
    low, high = model.bounds()
    alone = np.array([place not in rises for place in range(len(vector))])
    found[:, alone] = np.clip(found[:, alone], low[alone], high[alone])
    for row in found if len(rises) > 1 else ():
        row[rises] = isotonic_regression(row[rises]).x
    return model.plain(found)
