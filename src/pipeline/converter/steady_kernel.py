"""The kernel behind `steady.trace`: one matrix a sample, each from the start of its period."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.topologies import SIZE
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
