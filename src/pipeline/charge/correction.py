"""Newton's correction of the main currents at the nodes of a step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import PASSED
from pipeline.charge.lanes import put
from pipeline.charge.state import (
    CURRENT_CONTROL,
    ETA_BY_DEPTH,
    ETA_SLOPE,
    MAIN,
    OHM,
    OHM_SLOPE,
    OPEN_SLOPE,
    POWER_CONTROL,
    SIDE_SLOPE,
    TERMINAL_V,
    TOTAL,
    Run,
)
from pipeline.jit import inlined


@inlined
def correct(cell: Cell, run: Run, slot: int, control: int, bypassed: bool) -> None:
    """Replace the residuals of the nodes by Newton's corrections of their main currents.

    Near the start of a step the change of the circuit with depth is nothing beside its resistance, and left out.
    """
    at, m = run.at, run.jacobian
    near = run.near and cell.transfer == 0
    for n in range(3):
        a = b = c = d = 0.0
        for k in range(cell.pairs + cell.acceptance):
            if not (bypassed and k == cell.pairs):
                w, r = run.node[slot, k, n], run.resistance[k, n]
                a, b, c, d = a + w[0] * r, b + w[1] * r, c + w[2] * r, d + w[3] * r
        put(m[n], a, b, c, d)
    if not near:
        _add_depth(cell, run, slot, bypassed)
    for n in range(3):
        m[n, n] += at[ETA_SLOPE, n]
    for j in range(3):
        for n in range(3):
            node = m[n, j]
            total = at[SIDE_SLOPE, j] * node + (1.0 if n == j else 0.0)
            if control == CURRENT_CONTROL:
                m[n, j] = total
                continue
            m[n, j] = node + at[OHM, j] * total
            if not near:
                per_charge = run.length_s[slot] / cell.charge_as
                m[n, j] -= per_charge * PASSED[n, j] * run.depth_slope[OHM_SLOPE, j] * at[TOTAL, j]
            if control == POWER_CONTROL:
                m[n, j] = m[n, j] * at[TOTAL, j] + at[TERMINAL_V, j] * total
    _solve(m, run.residual)


@inlined
def _add_depth(cell: Cell, run: Run, slot: int, bypassed: bool) -> None:
    """Add what the main currents do to the node voltages through the depth of discharge."""
    at, m = run.at, run.jacobian
    per_charge = run.length_s[slot] / cell.charge_as
    for j in range(3):
        with_x = run.depth_slope[OPEN_SLOPE, j] + run.depth_slope[ETA_BY_DEPTH, j]
        for n in range(3):
            by_depth = 0.0
            for k in range(cell.pairs + cell.acceptance):
                if not (bypassed and k == cell.pairs):
                    by_depth += run.node[slot, k, n, j] * run.slope[k, n]
            run.row[n] = by_depth * at[MAIN, n]
        for n in range(3):
            drift = PASSED[n, 0] * run.row[0] + PASSED[n, 1] * run.row[1] + PASSED[n, 2] * run.row[2]
            m[n, j] -= per_charge * (with_x * PASSED[n, j] + drift)


@inlined
def _solve(m: NDArray[np.float64], r: NDArray[np.float64]) -> None:
    """Solve a 3 x 3 system in place by elimination, m[n, j] being what unknown n does to equation j."""
    f, g = m[0, 1] / m[0, 0], m[0, 2] / m[0, 0]
    m11, m12, r1 = m[1, 1] - f * m[1, 0], m[2, 1] - f * m[2, 0], r[1] - f * r[0]
    m21, m22, r2 = m[1, 2] - g * m[1, 0], m[2, 2] - g * m[2, 0], r[2] - g * r[0]
    f = m21 / m11
    last = (r2 - f * r1) / (m22 - f * m12)
    middle = (r1 - m12 * last) / m11
    put(r, (r[0] - m[1, 0] * middle - m[2, 0] * last) / m[0, 0], middle, last, 0.0)
