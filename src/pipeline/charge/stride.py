"""A stride over many periods: its record, the weights with which its three nodes move the state, Newton's correction.

The state before each period is followed as a function of the count of periods. What a period adds is taken to be
quadratic in that count, through one period run at each node of Radau IIA; the sums of the quadratic are exact. A
relaxation multiplies what there was by the same factor in every period, so it is followed exactly too, however fast.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import MOST_RELAXATIONS, Cell
from pipeline.cell.relaxation import LAGRANGE, NODES, phi_functions, response
from pipeline.charge.record_keeping import SUMS
from pipeline.charge.state import HYSTERESIS, PAIR_HEAT, RELAXATIONS, put
from pipeline.jit import inlined, kernel, new_record

PARTS = RELAXATIONS + MOST_RELAXATIONS
# What a period adds beside the state: sums of the book, gains, changes of control; what is seen in it.
GAINS_FROM = SUMS
CHANGES = SUMS + PAIR_HEAT + MOST_RELAXATIONS
ADDED = CHANGES + 1
PEAK_K = 4
SEEN = 5
# Rows after the three nodes: the period at the start, one that is tried; among states and weights, the end.
FIRST, TRIED = 3, 4
END = 3

STRIDE = np.dtype(
    [
        ("before", np.float64, (PARTS,)),
        ("place", np.float64, (5, PARTS)),
        ("ratio", np.float64, (PARTS,)),
        ("kept", np.float64, (PARTS,)),
        ("weighed_for", np.float64, (PARTS,)),
        ("left", np.float64, (PARTS, 4)),
        ("weight", np.float64, (PARTS, 3, 4)),
        ("forcing", np.float64, (3, PARTS)),
        ("past", np.float64, (3, PARTS)),
        ("measured", np.float64, (5, PARTS)),
        ("added", np.float64, (5, ADDED)),
        ("seen", np.float64, (5, SEEN)),
        ("scale", np.float64, (PARTS,)),
        ("slope", np.float64, (PARTS, PARTS)),
        ("matrix", np.float64, (3 * PARTS, PARTS, 4)),
        ("factors", np.float64, (3 * PARTS, 3 * PARTS)),
        ("pivots", np.int64, (3 * PARTS,)),
        ("stood", np.float64, (3, PARTS)),
        ("was", np.float64, (3, PARTS)),
        ("right", np.float64, (3 * PARTS,)),
        ("phi", np.float64, (8,)),
        ("row", np.float64, (3,)),
        ("shift", np.float64, (3, 3)),
        ("nudge", np.float64, (PARTS,)),
        ("proposal", np.float64),
        ("factor", np.float64),
        ("mismatch", np.float64),
        ("rate", np.float64),
        ("error", np.float64),
        ("refused", np.float64),
        ("phase", np.int64),
        ("at", np.int64),
        ("part", np.int64),
        ("count", np.int64),
        ("iteration", np.int64),
        ("fresh", np.int64),
        ("edges_before", np.int64),
        ("all_changes", np.int64),
        ("changes_before", np.int64),
        ("last", np.int64),
        ("rate_count", np.int64),
        ("weighed", np.int64),
        ("shortened", np.int64),
        ("alone", np.int64),
        ("trusted", np.int64),
        ("parts", np.int64),
        ("sloped", np.int64),
        ("eliminated", np.int64),
        ("tried", np.int64),
        ("taken", np.int64),
    ],
    align=True,
)
"""Everything of a stride.

place[j] : state before the period at node j, and at the end.
kept, ratio : what a period leaves of a part of the state, and -log of it.
left[k, j], weight[k, l, j] : part k at node j is left times its start plus weights times forcings; `weighed` and
    `weighed_for` are the count and the ratios that they belong to.
forcing[l, k] : what the period at node l adds to part k, `measured` what it did.
slope[m, k] : how what is measured of part m rises with part k.
stood, was : place and measured of the nodes at the iteration before.
rate, rate_count : share of the mismatch that the last iteration seen left, and periods of its stride; `trusted`:
    strides since then that ended by it.
error, refused : of the stride that is tried, and of the last that was refused, `alone` periods before; 0 where unknown.
matrix, factors, pivots : what elimination leaves of the system of a correction, and how; `eliminated` where it holds.
"""

Stride = Any


def new_stride() -> Stride:
    """Return the record of strides, before the first."""
    return new_record(STRIDE)


@kernel
def weigh(stride: Stride, count: int) -> None:
    """Compute the weights of a stride over so many periods, unless they are those of the stride before."""
    stride.eliminated = 0
    known = stride.weighed == count
    for k in range(stride.parts):
        known = known and stride.weighed_for[k] == stride.ratio[k]
    if known:
        return
    stride.weighed = count
    copy(stride.weighed_for, stride.ratio)
    like = -1
    for k in range(stride.parts):
        z = stride.ratio[k]
        if z != 0.0:
            _weigh_relaxation(stride, k, z, count)
            continue
        for j in range(4):
            theta = NODES[j] - 0.5 / count if j < 3 else 1.0
            stride.left[k, j] = 1.0
            for node in range(3):
                # Alike for every part that stays as it is.
                weight = passed_by(count, theta, node) if like < 0 else stride.weight[like, node, j]
                stride.weight[k, node, j] = weight
        like = k


@inlined
def passed_by(count: float, theta: float, node: int) -> float:
    """Return the sum, from the start to a fraction of the stride, of what is 1 at one node and 0 at the others."""
    cubic = LAGRANGE[0, node] + theta * (LAGRANGE[1, node] / 2.0 + theta * LAGRANGE[2, node] / 3.0)
    return float(count * theta * (cubic - LAGRANGE[2, node] / (12.0 * count * count)))


@inlined
def _weigh_relaxation(stride: Stride, k: int, z: float, count: int) -> None:
    # What a period adds, over 1 - exp(-z), is a weighted mean of the forcing in it; its moments undo the mean.
    phi, row, shift = stride.phi, stride.row, stride.shift
    phi_functions(-z, 3, phi)
    share, mean, square = z * phi[1], phi[2] / phi[1], 2.0 * phi[3] / phi[1]
    first, second = 0.5 - mean, 0.125 - 0.5 * mean + mean * mean - 0.5 * square
    for j in range(3):
        for node in range(3):
            slope = LAGRANGE[1, node] + 2.0 * NODES[j] * LAGRANGE[2, node]
            bend = 2.0 * LAGRANGE[2, node]
            shift[j, node] = (first / count * slope + second / (count * count) * bend + (j == node)) / share
    for j in range(4):
        theta = NODES[j] - 0.5 / count if j < 3 else 1.0
        stride.left[k, j] = response(z * count, theta, phi, row)
        for node in range(3):
            weight = row[0] * shift[0, node] + row[1] * shift[1, node] + row[2] * shift[2, node]
            stride.weight[k, node, j] = weight


@inlined
def move(stride: Stride, j: int) -> None:
    """Write the state before the period at node j, or at the end, that the forcings make."""
    for k in range(stride.parts):
        w, total = stride.weight[k], stride.left[k, j] * stride.before[k]
        for node in range(3):
            total += w[node, j] * stride.forcing[node, k]
        stride.place[j, k] = total


@inlined
def keep_ratios(cell: Cell, stride: Stride, period_s: float, moved: float) -> None:
    """Write what a period leaves of each part of the state; `moved` is the 1 - SOC it moved up and down."""
    stride.parts = RELAXATIONS + cell.relaxations
    stride.ratio[:RELAXATIONS] = 0.0
    stride.ratio[HYSTERESIS] = cell.hysteresis_per_depth * moved
    for k in range(cell.relaxations):
        stride.ratio[RELAXATIONS + k] = period_s / cell.tau_s[k]
    for k in range(stride.parts):
        stride.kept[k] = math.exp(-stride.ratio[k])


@kernel
def at_node_fraction(a: float, b: float, c: float, theta: float) -> float:
    """Return the quadratic through three values at the nodes."""
    total = a * (LAGRANGE[0, 0] + theta * (LAGRANGE[1, 0] + theta * LAGRANGE[2, 0]))
    total += b * (LAGRANGE[0, 1] + theta * (LAGRANGE[1, 1] + theta * LAGRANGE[2, 1]))
    total += c * (LAGRANGE[0, 2] + theta * (LAGRANGE[1, 2] + theta * LAGRANGE[2, 2]))
    return float(total)


@kernel
def highest(a: float, b: float, c: float) -> float:
    """Return the highest value over the stride of the quadratic through three values at the nodes."""
    one = a * LAGRANGE[1, 0] + b * LAGRANGE[1, 1] + c * LAGRANGE[1, 2]
    two = a * LAGRANGE[2, 0] + b * LAGRANGE[2, 1] + c * LAGRANGE[2, 2]
    top = max(a, max(b, c))
    if two < 0.0:
        theta = -0.5 * one / two
        if 0.0 < theta < 1.0:
            top = max(top, at_node_fraction(a, b, c, theta))
    return float(top)


@inlined
def copy(to: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Copy one row to another."""
    for n in range(len(values)):
        to[n] = values[n]


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


@inlined
def improve_slopes(stride: Stride) -> None:
    """Let the slopes give what the last correction did at each node (Broyden's first method, scaled by the nudges).

    Source: C. G. Broyden, Mathematics of Computation 19 (1965) 577.
    """
    stride.sloped, stride.eliminated = 1, 0
    for j in range(3):
        size = 0.0
        for k in range(stride.parts):
            stride.right[k] = (stride.place[j, k] - stride.stood[j, k]) / stride.nudge[k]
            size += stride.right[k] * stride.right[k]
        for m in range(stride.parts):
            miss = stride.measured[j, m] - stride.was[j, m]
            for k in range(stride.parts):
                miss -= stride.slope[m, k] * stride.nudge[k] * stride.right[k]
            for k in range(stride.parts):
                if size > 0.0:
                    stride.slope[m, k] += miss * stride.right[k] / (size * stride.nudge[k])


@kernel
def correct(stride: Stride) -> None:
    """Move the forcings towards what was measured, by Newton's method where slopes are known.

    Everything in units of the scales: one equation for each part and node.
    """
    parts, scale, right = stride.parts, stride.scale, stride.right
    for j in range(3):
        copy(stride.stood[j], stride.place[j])
        copy(stride.was[j], stride.measured[j])
    for m in range(parts):
        for j in range(3):
            right[3 * m + j] = (stride.measured[j, m] - stride.forcing[j, m]) / scale[m]
    if stride.sloped == 1:
        if stride.eliminated == 0:
            _eliminate(stride)
        _solve(stride, 3 * parts)
    for m in range(parts):
        for j in range(3):
            stride.forcing[j, m] += right[3 * m + j] * scale[m]


@inlined
def _eliminate(stride: Stride) -> None:
    """Write the system of a correction and eliminate it with pivots from the column, four unknowns at a time."""
    matrix, parts, scale = stride.matrix, stride.parts, stride.scale
    for m in range(parts):
        for k in range(parts):
            ratio, w = stride.slope[m, k] * scale[k] / scale[m], stride.weight[k]
            for j in range(3):
                put(matrix[3 * m + j, k], -ratio * w[0, j], -ratio * w[1, j], -ratio * w[2, j], 0.0)
                if m == k:
                    matrix[3 * m + j, k, j] += 1.0
    for column in range(3 * parts):
        block, lane = column // 3, column % 3
        pivot = column
        for row in range(column + 1, 3 * parts):
            if abs(matrix[row, block, lane]) > abs(matrix[pivot, block, lane]):
                pivot = row
        stride.pivots[column] = pivot
        if pivot != column:
            for k in range(block, parts):
                for n in range(4):
                    matrix[pivot, k, n], matrix[column, k, n] = matrix[column, k, n], matrix[pivot, k, n]
        reciprocal = 1.0 / matrix[column, block, lane]
        for row in range(column + 1, 3 * parts):
            factor = matrix[row, block, lane] * reciprocal
            stride.factors[column, row] = factor
            if factor != 0.0:
                # What lies before the column is not read again.
                for k in range(block, parts):
                    own, above = matrix[row, k], matrix[column, k]
                    put(
                        own,
                        own[0] - factor * above[0],
                        own[1] - factor * above[1],
                        own[2] - factor * above[2],
                        own[3] - factor * above[3],
                    )
    stride.eliminated = 1


@inlined
def _solve(stride: Stride, size: int) -> None:
    """Solve the eliminated system in place."""
    matrix, right, factors = stride.matrix, stride.right, stride.factors
    for column in range(size):
        pivot = stride.pivots[column]
        if pivot != column:
            right[pivot], right[column] = right[column], right[pivot]
        for row in range(column + 1, size):
            if factors[column, row] != 0.0:
                right[row] -= factors[column, row] * right[column]
    for row in range(size - 1, -1, -1):
        block, lane, total = row // 3, row % 3, right[row]
        own = matrix[row]
        for n in range(lane + 1, 3):
            total -= own[block, n] * right[3 * block + n]
        for k in range(block + 1, size // 3):
            total -= own[k, 0] * right[3 * k]
            total -= own[k, 1] * right[3 * k + 1]
            total -= own[k, 2] * right[3 * k + 2]
        right[row] = total / own[block, lane]
