"""The logistic map x -> r x (1 - x), which the chaotic swarm draws its numbers from (eq. 4), and its exact invariants.

At r = 4 its density is 1 / (pi sqrt(x (1 - x))), the arcsine law, not the uniform one: x = sin^2(pi u / 2) with u
uniform (Ulam and von Neumann, Bull. Am. Math. Soc. 53 (1947) 1120).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FULL_CHAOS = 4.0
ESCAPE = 0.1234567
"""Where an orbit goes on from a point from which it would never come back."""


def logistic(x: Any, r: Any = FULL_CHAOS) -> Any:
    """Return the map's next value for x in [0, 1] and r in [0, 4]."""
    return r * x * (1.0 - x)


def guarded(x: ArrayLike) -> Array:
    """Replace the points whose orbit at r = 4 ends in a fixed point at once: 0, 1/4, 1/2, 3/4 and 1.

    Their preimages reach one of them, if rounding does not lead them away, so it is enough to guard every step.
    """
    values = np.asarray(x, dtype=float)
    quarters = 4.0 * values
    return np.where(quarters == np.floor(quarters), ESCAPE, values)


def orbit(start: ArrayLike, steps: int, r: ArrayLike = FULL_CHAOS, transient: int = 0) -> Array:
    """Return successive values of the map.

    Arguments
    ---------
    start : first values, shape (...), before the transient.
    steps : how many values to return.
    r : the map's parameter, broadcast against `start`.
    transient : how many steps to take before the first value returned.

    Returns
    -------
    Values, shape (steps, ...); the first is `start` itself where there is no transient.
    """
    x, parameter = np.broadcast_arrays(np.asarray(start, dtype=float), np.asarray(r, dtype=float))
    for _ in range(transient):
        x = logistic(x, parameter)
    values = np.empty((steps, *x.shape))
    for step in range(steps):
        values[step] = x
        x = logistic(x, parameter)
    return values


def arcsine(uniform: ArrayLike) -> Array:
    """Return arcsine-distributed values made from uniform ones by the inverse of the distribution function."""
    result: Array = np.sin(0.5 * np.pi * np.asarray(uniform, dtype=float)) ** 2
    return result


def arcsine_cumulative(x: ArrayLike) -> Array:
    """Return the distribution function of the arcsine law, 2/pi asin(sqrt(x))."""
    result: Array = 2.0 / np.pi * np.arcsin(np.sqrt(np.asarray(x, dtype=float)))
    return result


def arcsine_entropy(bins: int) -> float:
    """Return the exact Shannon entropy [nats] of the map at r = 4 in equal bins over [0, 1]."""
    share = np.diff(arcsine_cumulative(np.linspace(0.0, 1.0, bins + 1)))
    return float(-np.sum(share * np.log(share)))
