"""A converter at a fixed duty: its periodic state in closed form, its ripple, and traces by one map a sample."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.topologies import DIODE, INDUCTOR, LOW, ON, ONE, SIZE, Topologies, exponential
from pipeline.jit import kernel

Array = NDArray[np.float64]


def from_start(maps: Array) -> Array:
    """Return the transposed maps from the start of a period to each of its samples, shape (samples, 4, 4).

    Samples then wait for the period's start alone, not for one another.

    Arguments
    ---------
    maps : those from each sample to the next, shape (samples, 4, 4).
    """
    found, whole = np.empty_like(maps), np.eye(SIZE)
    for sample, one in enumerate(maps):
        whole = one @ whole
        found[sample] = whole.T
    return found


@kernel
def trace_samples(maps: Array, state: Array, points: Array) -> None:
    """Fill in z at every sample.

    Arguments
    ---------
    maps : as `from_start` returns them, shape (samples, 4, 4).
    state : z at the start, shape (4,).
    points : z at each sample and at the end, shape (periods samples + 1, 4).
    """
    samples, last = maps.shape[0], points.shape[0] - 1
    a, b, c, d = state[0], state[1], state[2], state[3]
    points[0, 0], points[0, 1], points[0, 2], points[0, 3] = a, b, c, d
    for begin in range(0, last, samples):
        for sample in range(min(samples, last - begin)):
            m, point = maps[sample], points[begin + sample + 1]
            for row in range(SIZE):
                point[row] = (m[0, row] * a + m[1, row] * b) + (m[2, row] * c + m[3, row] * d)
        end = points[min(begin + samples, last)]
        a, b, c, d = end[0], end[1], end[2], end[3]


class Steady(NamedTuple):
    """A periodic state: z at the start of a period, the means of z over it, and what it needs to be true.

    `valley_a` is the least inductor current; below zero a converter whose second switch is a diode does otherwise.
    """

    state: Array
    mean: Array
    valley_a: float


def steady_state(topologies: Topologies, synchronous: bool, duty: float, period_s: float) -> Steady:
    """Return the periodic state at a fixed duty, from the fixed point of the affine map of a period.

    Arguments
    ---------
    topologies : the converter's circuits.
    synchronous : which circuit follows the switch.
    duty : share of the period for which the switch is on [1].
    period_s : length of a switching period [s].
    """
    off = LOW if synchronous else DIODE
    on_map, on_sum = exponential(topologies.generators[ON], duty * period_s)
    off_map, off_sum = exponential(topologies.generators[off], (1.0 - duty) * period_s)
    whole = off_map @ on_map
    state = np.ones(SIZE)
    state[:ONE] = np.linalg.solve(np.eye(ONE) - whole[:ONE, :ONE], whole[:ONE, ONE])
    mean = (on_sum @ state + off_sum @ on_map @ state) / period_s
    return Steady(state, mean, float(min(state[INDUCTOR], (on_map @ state)[INDUCTOR])))


def sample_maps(
    topologies: Topologies, synchronous: bool, duty: float, period_s: float, samples: int
) -> tuple[Array, NDArray[np.int64]]:
    """Return the map from each sample of a period to the next, shape (samples, 4, 4), and its circuits, (samples,)."""
    off = LOW if synchronous else DIODE
    length, on_s = period_s / samples, duty * period_s
    whole = {place: exponential(topologies.generators[place], length)[0] for place in (ON, off)}
    found, places = np.empty((samples, SIZE, SIZE)), np.empty(samples, dtype=np.int64)
    for sample in range(samples):
        on = min(max(on_s - sample * length, 0.0), length)
        places[sample] = ON if on > 0.0 else off
        if 0.0 < on < length:
            first = exponential(topologies.generators[ON], on)[0]
            found[sample] = exponential(topologies.generators[off], length - on)[0] @ first
        else:
            found[sample] = whole[places[sample]]
    return found, places


def trace(
    topologies: Topologies, synchronous: bool, duty: float, period_s: float, samples: int, state: Array, periods: int
) -> Array:
    """Return z at every sample of some periods at a fixed duty, shape (periods samples + 1, 4).

    Arguments
    ---------
    state : z at the start, shape (4,).
    """
    made, _ = sample_maps(topologies, synchronous, duty, period_s, samples)
    points = np.empty((periods * samples + 1, SIZE))
    trace_samples(from_start(made), np.asarray(state, dtype=np.float64), points)
    return points
