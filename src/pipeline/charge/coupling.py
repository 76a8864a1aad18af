"""How what the nodes of a stride measure depends on where they stand: slopes, and Newton's correction from them."""

from __future__ import annotations

from pipeline.charge.stride import TRIED, Stride, copy
from pipeline.jit import inlined, kernel

_MIDDLE = 1


@inlined
def nudge(stride: Stride, k: int) -> None:
    """Write the middle node's state with one part nudged, to be tried."""
    copy(stride.place[TRIED], stride.place[_MIDDLE])
    stride.place[TRIED, k] += stride.nudge[k]


@inlined
def keep_slope(stride: Stride, k: int) -> None:
    """Keep how what was measured rose with the part that was nudged."""
    for m in range(stride.parts):
        stride.slope[m, k] = (stride.measured[TRIED, m] - stride.measured[_MIDDLE, m]) / stride.nudge[k]


@kernel
def correct(stride: Stride) -> None:
    """Move the forcings towards what was measured, by Newton's method where slopes are known.

    Everything in units of the scales: one equation for each part and node.
    """
    parts, scale, right = stride.parts, stride.scale, stride.right
    for m in range(parts):
        for j in range(3):
            right[3 * m + j] = (stride.measured[j, m] - stride.forcing[j, m]) / scale[m]
    if stride.sloped == 1:
        matrix = stride.matrix
        for m in range(parts):
            for k in range(parts):
                ratio = stride.slope[m, k] * scale[k] / scale[m]
                for j in range(3):
                    for node in range(3):
                        matrix[3 * m + j, 3 * k + node] = -ratio * stride.weight[k, node, j]
        for row in range(3 * parts):
            matrix[row, row] += 1.0
        _solve(stride, 3 * parts)
    for m in range(parts):
        for j in range(3):
            stride.forcing[j, m] += right[3 * m + j] * scale[m]


@inlined
def _solve(stride: Stride, size: int) -> None:
    """Solve the system in place by elimination with pivots from the column."""
    matrix, right = stride.matrix, stride.right
    for column in range(size):
        pivot = column
        for row in range(column + 1, size):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        if pivot != column:
            for other in range(column, size):
                matrix[pivot, other], matrix[column, other] = matrix[column, other], matrix[pivot, other]
            right[pivot], right[column] = right[column], right[pivot]
        reciprocal = 1.0 / matrix[column, column]
        for row in range(column + 1, size):
            factor = matrix[row, column] * reciprocal
            if factor != 0.0:
                for other in range(column + 1, size):
                    matrix[row, other] -= factor * matrix[column, other]
                right[row] -= factor * right[column]
    for row in range(size - 1, -1, -1):
        total = right[row]
        for other in range(row + 1, size):
            total -= matrix[row, other] * right[other]
        right[row] = total / matrix[row, row]
