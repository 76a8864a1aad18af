"""How well a fit knows its numbers: covariance, profiles, what is not identified, draws from the fit's distribution.

Residuals of a replay go together over many rows. The information of n rows is therefore taken to be that of the
effective n / (1 + 2 sum rho_k), with the autocorrelation rho of the residuals in the order of the rows, summed up to
where two neighbours of it no longer come to more than nothing (Geyer, Statistical Science 7 (1992) 473).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.own_battery.fitting import Problem, Result, solve
from pipeline.experiments.own_battery.unknowns import Model

Array = NDArray[np.float64]
NORMAL_95 = 1.959963984540054
_AT_BOUND = 1e-3
_SECANTS, _STEPS, _NEAR, _PROFILE_TOLERANCE = 4, 12, 0.05, 3e-5
"""Steps to an end of a profile, evaluations of the fit at each, and when these are near enough."""


class Certainty(NamedTuple):
    """What a fit knows.

    Arguments
    ---------
    model, vector, covariance : of all numbers, those that keep their priors with these, (D,) and (D, D).
    low, high : ends of the 95 % intervals of the fitted numbers, logarithms where these count, from profiles where
        these were taken, with what the priors of the others leave open, (d,) each.
    identified : whether a fitted number is known better than before the measurement, (d,).
    rows, effective : rows of voltage that the fit saw, and how many independent ones they are worth.
    """

    model: Model
    vector: Array
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
    volts = problem.voltages
    ends = np.cumsum([0, volts, problem.temperatures, problem.currents]).tolist()
    kinds = [slice(*both) for both in itertools.pairwise(ends)]
    bread = slopes.T @ (weight[:, None] * slopes)
    before = slopes[ends[-1] :]
    filling = before.T @ before
    effective = float(volts)
    for kind in kinds:
        if kind.stop <= kind.start:
            continue
        scores = weight[kind] * missed[kind]
        factor = inflation(scores)
        # Each row with its own spread: rounded, a voltage between two steps scatters more than one upon a step.
        own = scores[:, None] * slopes[kind]
        filling += factor * len(scores) / max(len(scores) - len(vector), 1) * own.T @ own
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
    """Return each interval's half-width over that of its prior; without end for a number at a bound.

    Of a positive number it is the smaller of those on its logarithm and on itself: a resistance that comes out small
    has a wide logarithm, though the measurement rules out most of what was plausible before.
    """
    half, prior = NORMAL_95 * np.sqrt(np.maximum(spread, 0.0)), model.priors()
    share = half / prior
    log = np.array([one.log for one in model.unknowns], dtype=bool)
    away = (vector - model.start())[log]
    share[log] = np.minimum(share[log], half[log] * np.exp(away) / np.sinh(prior[log]))
    low, high = model.bounds()
    reach = _AT_BOUND * (high - low)
    return np.where(~_tabled(model) & ((vector < low + reach) | (vector > high - reach)), np.inf, share)


def _tabled(model: Model) -> NDArray[np.bool_]:
    """Return which numbers are points of tables."""
    return np.array([".value." in path for path in model.paths], dtype=bool)


def settle(problem: Problem, vector: Array, robust: float) -> tuple[Problem, Result, list[str]]:
    """Let numbers that the measurement does not tell keep their priors, the worst first, and fit the others again.

    What it tells is judged by the measurement alone, at the vector that it finds together with the priors: without
    these, numbers that only their sum tells apart wander to their bounds, where any of them may be left. Points of
    tables stay, since each goes with the points beside it; they are only told apart in the end.

    Returns
    -------
    The problem of what is left, its fit without priors, and the key paths of what keeps its prior.
    """
    left: list[str] = []
    result = Result(problem.model, vector, math.inf, problem.evaluations, False)
    for _ in range(len(vector) + 1):
        drawn = Problem(problem.model, problem.parts, problem.spread, ridge=True)
        drawn.evaluations = problem.evaluations
        near = solve(drawn, vector, robust, 20)
        problem.evaluations = near.evaluations
        dropped = untold(problem, near.vector, robust)
        if dropped is None:
            # Once more without the priors: what goes to its bound then was held by its prior alone.
            result = solve(problem, near.vector, robust, 20)
            dropped = untold(problem, result.vector, robust)
        if dropped is None:
            break
        left.append(dropped)
        kept = np.array([path != dropped for path in problem.model.paths], dtype=bool)
        evaluations = problem.evaluations
        problem = Problem(problem.model.without([dropped]), problem.parts, problem.spread)
        problem.evaluations, vector = evaluations, near.vector[kept]
    return problem, result, left


def untold(problem: Problem, vector: Array, robust: float) -> str | None:
    """Return the key path of the number that a measurement tells least, if it does not tell it; none otherwise."""
    if not len(vector):
        return None
    return _least_known(problem.model, vector, covariance_of(problem, vector, robust)[0])


def _least_known(model: Model, vector: Array, covariance: Array) -> str | None:
    """Return the number that is known least beside its prior, of those that the measurement leaves near it.

    Only one: with it at its prior the others may be known well. None where every number is known better than by its
    prior, or so far from it that the measurement rules it out.
    """
    mixing = model.mixing()
    share, away = _beside_priors(model, vector, np.diag(mixing @ covariance @ mixing.T))
    open_ = ~_tabled(model) & (share >= 1.0) & ((away < NORMAL_95) | np.isinf(share))
    if not open_.any():
        return None
    # The widest first; one at its bound only when no other is left, since another's prior may bring it back. Before
    # all, what is left of a pair whose time constant is not told: series resistance and the other pairs have its place.
    rank = np.where(np.isinf(share), 1.0, share) + np.where(_of_untold_pairs(model), 1e300, 0.0)
    return model.paths[int(np.argmax(np.where(open_, rank, -1.0)))]


def _of_untold_pairs(model: Model) -> NDArray[np.bool_]:
    """Return which numbers are resistances of pairs whose time constants are fitted no longer."""
    paths = set(model.paths)
    return np.array(
        [
            path.startswith("pairs.") and f"{'.'.join(path.split('.')[:2])}.time_constant_s" not in paths
            for path in model.paths
        ],
        dtype=bool,
    )


def _beside_priors(model: Model, vector: Array, spread: Array) -> tuple[Array, Array]:
    """Return each interval's half-width over that of its prior, and how far a number is from it, in deviations.

    Arguments
    ---------
    spread : variances of the numbers, (d,).
    """
    spread = np.maximum(spread, 1e-300)
    moved = model.mixing() @ (vector - model.start())
    return _shares(model, vector, spread), np.abs(moved) / np.sqrt(spread)


def certainty_of(
    problem: Problem, result: Result, robust: float, whole: Model | None = None, profiles: int = 12
) -> Certainty:
    """Return what a fit knows of its numbers.

    Arguments
    ---------
    whole : the model with the numbers that keep their priors; none: every number is fitted.
    profiles : of how many numbers that are no points of tables the interval is taken from a profile, the least certain
        ones first; the others have that of the covariance.
    """
    vector, whole = result.vector, whole or problem.model
    count = len(vector)
    covariance, effective = covariance_of(problem, vector, robust) if count else (np.zeros((0, 0)), 0.0)
    every, joint, left_open = _with_priors(problem, vector, covariance, whole, robust)
    mixing = problem.model.mixing()
    spread = np.diag(mixing @ covariance @ mixing.T)
    left_open = np.diag(mixing @ left_open @ mixing.T)
    share, away = _beside_priors(problem.model, vector, spread + left_open)
    known = (share < 1.0) | (~_tabled(problem.model) & np.isfinite(share) & (away >= NORMAL_95))
    numbers, half = mixing @ vector, NORMAL_95 * np.sqrt(np.maximum(spread, 0.0))
    below, above = half.copy(), half.copy()
    alone = [place for place in np.flatnonzero(known & ~_tabled(problem.model)).tolist() if spread[place] > 0.0]
    if alone:
        slopes, missed = problem.slopes(vector), problem.function(vector)
        weight = 1.0 / np.sqrt(1.0 + (missed / robust) ** 2)
        bread = _inverse(slopes.T @ (weight[:, None] * slopes))
        base = _Base(vector, covariance, bread, _cost(problem, vector, robust))
        for place in sorted(alone, key=lambda one: -share[one])[:profiles]:
            below[place] = _profiled(problem, base, place, -1.0, robust)
            above[place] = _profiled(problem, base, place, 1.0, robust)
    more = NORMAL_95**2 * left_open
    low, high = numbers - np.sqrt(below**2 + more), numbers + np.sqrt(above**2 + more)
    rows = problem.voltages
    return Certainty(whole, every, joint, low, high, known, rows, effective if count else float(rows))


def _with_priors(
    problem: Problem, vector: Array, covariance: Array, whole: Model, robust: float
) -> tuple[Array, Array, Array]:
    """Return vector and covariance of all numbers, and what the priors of some leave open of the others.

    What keeps its prior may lie anywhere in it, and the fitted numbers move with it, by the slopes at the best vector:
    a series resistance is known no better than the pair behind it that is too fast to see.
    """
    places = {path: place for place, path in enumerate(whole.paths)}
    fitted = np.array([places[path] for path in problem.model.paths], dtype=int)
    kept = np.array([place for path, place in places.items() if path not in problem.model.paths], dtype=int)
    every, joint = whole.start(), np.zeros((len(places), len(places)))
    every[fitted] = vector
    joint[np.ix_(fitted, fitted)] = covariance
    known_before = np.zeros(len(places))
    known_before[fitted] = NORMAL_95 / whole.widths()[fitted]
    if not len(kept):
        return every, _with_information(joint, known_before), np.zeros_like(covariance)
    prior = np.diag((whole.priors()[kept] / NORMAL_95) ** 2)
    joint[np.ix_(kept, kept)] = prior
    if not len(fitted):
        return every, joint, np.zeros((0, 0))
    full = Problem(whole, problem.parts, problem.spread)
    slopes, missed = full.slopes(every), full.function(every)
    problem.evaluations += full.evaluations
    weighted = (1.0 / np.sqrt(1.0 + (missed / robust) ** 2))[:, None] * slopes[:, fitted]
    moves = -_inverse(slopes[:, fitted].T @ weighted) @ (weighted.T @ slopes[:, kept])
    left_open = moves @ prior @ moves.T
    joint[np.ix_(fitted, fitted)] += left_open
    joint[np.ix_(fitted, kept)] = moves @ prior
    joint[np.ix_(kept, fitted)] = prior @ moves.T
    return every, _with_information(joint, known_before), left_open


def _with_information(covariance: Array, information: Array) -> Array:
    """Return a covariance where each number is also known by itself, to 1 / information; nothing of zero.

    Draws of what the measurement does not tell stay in what is plausible without it.
    """
    scaled = information[:, None] * covariance
    inner = np.eye(len(information)) + scaled * information
    return np.asarray(covariance - scaled.T @ np.linalg.solve(inner, scaled))


class _Base(NamedTuple):
    """From where profiles start: the best vector, its covariance, the inverse curvature of the loss, the loss."""

    vector: Array
    covariance: Array
    inverse: Array
    cost: float


def _profiled(problem: Problem, base: _Base, place: int, side: float, robust: float) -> float:
    """Return how far a number may go before the loss, the others fitted again, rises by what 95 % allow.

    The rise that is allowed is that which a parabola with the covariance would have there, so that the effective number
    of rows enters; the secant method from there finds where the real rise is the same, or the bound.
    """
    deviation = math.sqrt(base.covariance[place, place])
    allowed = 0.5 / base.inverse[place, place] * (NORMAL_95 * deviation) ** 2
    low, high = (end[place] - base.vector[place] for end in problem.model.bounds())
    reach, others = float(np.clip(side * NORMAL_95 * deviation, low, high)), base.vector
    for _ in range(_SECANTS):
        along = base.vector + base.inverse[:, place] / base.inverse[place, place] * reach
        # The nearer of the two to begin with: along the parabola, or where the last point of the profile was.
        near = min((along, others), key=lambda one: _cost(problem, _with(problem, one, place, base, reach), robust))
        others, rise = _refitted(problem, _with(problem, near, place, base, reach), place, robust)
        ratio = math.sqrt(allowed / max(rise - base.cost, 1e-12 * allowed))
        wanted = float(np.clip(reach * min(max(ratio, 0.3), 2.0), low, high))
        if abs(wanted - reach) < _NEAR * abs(reach):
            return abs(wanted)
        reach = wanted
    return abs(reach)


def _with(problem: Problem, vector: Array, place: int, base: _Base, reach: float) -> Array:
    """Return a vector inside its bounds, one number of it a way off the best one."""
    found = np.clip(vector, *problem.model.bounds())
    found[place] = base.vector[place] + reach
    return np.asarray(found)


def _refitted(problem: Problem, vector: Array, place: int, robust: float) -> tuple[Array, float]:
    """Return a vector with every number but one fitted again, and its loss."""
    model, others = problem.model, np.arange(len(vector)) != place
    number = float(model.plain((model.mixing() @ vector)[None])[0, place])
    fixed = Problem(model.without([model.paths[place]], {model.paths[place]: number}), problem.parts, problem.spread)
    found = solve(fixed, vector[others], robust, _STEPS, _PROFILE_TOLERANCE)
    problem.evaluations += fixed.evaluations
    vector = vector.copy()
    vector[others] = found.vector
    return vector, found.cost


def _cost(problem: Problem, vector: Array, robust: float) -> float:
    return float(_costs(problem, vector[None], robust)[0])


def _costs(problem: Problem, vectors: Array, robust: float) -> Array:
    z = (problem.residuals(vectors) / robust) ** 2
    return np.asarray(0.5 * robust**2 * np.sum(2.0 * (np.sqrt(1.0 + z) - 1.0), axis=1))


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
