"""The kernel behind `steady.trace`: one matrix a sample."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.topologies import SIZE
from pipeline.jit import kernel

Array = NDArray[np.float64]


@kernel
def trace_samples(transposed: Array, state: Array, points: Array) -> None:
    """Fill in z at every sample.

    Arguments
    ---------
    transposed : transposed maps of the samples of a period, shape (samples, 4, 4).
    state : z at the start, shape (4,).
    points : z at each sample and at the end, shape (periods samples + 1, 4).
    """
    samples = transposed.shape[0]
    for row in range(SIZE):
        points[0, row] = state[row]
    sample = 0
    for here in range(points.shape[0] - 1):
        a, b, c, d = points[here, 0], points[here, 1], points[here, 2], points[here, 3]
        for row in range(SIZE):
            points[here + 1, row] = (
                transposed[sample, 0, row] * a
                + transposed[sample, 1, row] * b
                + transposed[sample, 2, row] * c
                + transposed[sample, 3, row] * d
            )
        sample = sample + 1 if sample + 1 < samples else 0
