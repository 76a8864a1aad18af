"""How disordered the logistic map is over r: binned Shannon entropy and Lyapunov exponent.

The two do not agree on where the disorder is largest, so both are computed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.jit import jit

Array = NDArray[np.float64]


class Disorder(NamedTuple):
    """Per parameter r: entropy of the visits to equal bins [nats] and Lyapunov exponent [nats per step]."""

    r: Array
    entropy: Array
    lyapunov: Array


def disorder(r: ArrayLike, bins: int, steps: int = 100_000, transient: int = 2_000, start: float = 0.7) -> Disorder:
    """Measure the map's disorder along one orbit per parameter.

    Arguments
    ---------
    r : parameters in (0, 4], shape (n,).
    bins : equal bins over [0, 1].
    steps : length of the orbit, after the transient.
    transient : steps taken before.
    start : where each orbit begins.

    Returns
    -------
    Both measures, shape (n,) each.
    """
    parameters = np.atleast_1d(np.asarray(r, dtype=float))
    counts, exponents = _measure(parameters, bins, steps, transient, start)
    share = counts / steps
    entropy = -np.sum(np.where(share > 0.0, share * np.log(np.where(share > 0.0, share, 1.0)), 0.0), axis=1)
    return Disorder(parameters, entropy, exponents)


@jit
def _measure(r: Array, bins: int, steps: int, transient: int, start: float) -> tuple[Array, Array]:
    counts = np.zeros((len(r), bins))
    exponents = np.empty(len(r))
    for index in range(len(r)):
        x = start
        for _ in range(transient):
            x = r[index] * x * (1.0 - x)
        total = 0.0
        for _ in range(steps):
            counts[index, min(int(x * bins), bins - 1)] += 1.0
            total += math.log(max(abs(r[index] * (1.0 - 2.0 * x)), 1e-300))
            x = r[index] * x * (1.0 - x)
        exponents[index] = total / steps
    return counts, exponents
