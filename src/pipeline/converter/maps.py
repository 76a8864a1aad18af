"""From generators to exact maps: matrix exponentials and their integrals, once for each length of interval."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.topologies import SIZE, Topologies

Array = NDArray[np.float64]

SERIES_REACH = 0.1
"""Norm of G t up to which ten terms of the exponential's series leave less than rounding."""


class Maps(NamedTuple):
    """What the kernel needs of each circuit.

    Arguments
    ---------
    generators : G of dz/dt = G z, shape (n, 4, 4).
    steps, sums : exp(G t), and its integral over t, for t = 0, tick, ... up to one sample, shape (n, m + 1, 4, 4).
    tick_s : sample over m; a series bridges what is left of a tick [s].
    sample_s, samples : distance of the samples [s], and how many there are in a switching period.
    outputs : rows that read the outputs, shape (n, 2, 4).
    """

    generators: Array
    steps: Array
    sums: Array
    tick_s: float
    sample_s: float
    samples: int
    outputs: Array


def exponential(generator: Array, length_s: float) -> tuple[Array, Array]:
    """Return exp(G t) and its integral from 0 to t, by one exponential of the doubled system (Van Loan 1978).

    DOI 10.1109/TAC.1978.1101743.
    """
    from scipy.linalg import expm

    size = len(generator)
    doubled = np.zeros((2 * size, 2 * size))
    doubled[:size, :size] = generator * length_s
    doubled[:size, size:] = np.eye(size) * length_s
    found = expm(doubled)
    return found[:size, :size], found[:size, size:]


def maps(topologies: Topologies, period_s: float, samples: int) -> Maps:
    """Return the maps of all circuits.

    Arguments
    ---------
    topologies : generators and outputs.
    period_s : length of a switching period [s].
    samples : samples of a switching period.
    """
    sample_s = period_s / samples
    norm = float(np.abs(topologies.generators).sum(axis=2).max())
    ticks = max(1, math.ceil(norm * sample_s / SERIES_REACH))
    count = len(topologies.generators)
    steps, sums = np.zeros((2, count, ticks + 1, SIZE, SIZE))
    for place, generator in enumerate(topologies.generators):
        step, integral = exponential(generator, sample_s / ticks)
        steps[place, 0] = np.eye(SIZE)
        for tick in range(ticks):
            steps[place, tick + 1] = step @ steps[place, tick]
            sums[place, tick + 1] = sums[place, tick] + integral @ steps[place, tick]
    return Maps(topologies.generators, steps, sums, sample_s / ticks, sample_s, samples, topologies.outputs)
