"""Newton's correction of the main currents at the nodes of a step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import RADAU
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
    """Replace the residuals of the nodes by Newton's corrections of their main currents."""
    at, m = run.at, run.jacobian
    per_charge = run.length_s[slot] / cell.charge_as
    for j in range(3):
        with_x = run.depth_slope[OPEN_SLOPE, j] + run.depth_slope[ETA_BY_DEPTH, j]
        for n in range(3):
            # Through the forcing of node n: by its current, and by its x in every forcing that depends on it.
            by_current, by_depth = 0.0, 0.0
            for k in range(cell.pairs + cell.acceptance):
                if not (bypassed and k == cell.pairs):
                    by_current += run.node[slot, k, n, j] * run.resistance[k, n]
                    by_depth += run.node[slot, k, n, j] * run.slope[k, n]
            m[j, n] = by_current
            run.row[n] = by_depth * at[MAIN, n]
        for n in range(3):
            drift = RADAU[0, n] * run.row[0] + RADAU[1, n] * run.row[1] + RADAU[2, n] * run.row[2]
            m[j, n] -= per_charge * (with_x * RADAU[j, n] + drift)
        m[j, j] += at[ETA_SLOPE, j]
        for n in range(3):
            node = m[j, n]
            total = at[SIDE_SLOPE, j] * node + (1.0 if n == j else 0.0)
            if control == CURRENT_CONTROL:
                m[j, n] = total
                continue
            ohm_drift = per_charge * RADAU[j, n] * run.depth_slope[OHM_SLOPE, j] * at[TOTAL, j]
            m[j, n] = node + at[OHM, j] * total - ohm_drift
            if control == POWER_CONTROL:
                m[j, n] = m[j, n] * at[TOTAL, j] + at[TERMINAL_V, j] * total
    _solve(m, run.residual)


@inlined
def _solve(m: NDArray[np.float64], r: NDArray[np.float64]) -> None:
    """Solve a 3 x 3 system in place by elimination with row scaling left to the caller's units."""
    f = m[1, 0] / m[0, 0]
    m11, m12, r1 = m[1, 1] - f * m[0, 1], m[1, 2] - f * m[0, 2], r[1] - f * r[0]
    f = m[2, 0] / m[0, 0]
    m21, m22, r2 = m[2, 1] - f * m[0, 1], m[2, 2] - f * m[0, 2], r[2] - f * r[0]
    f = m21 / m11
    r[2] = (r2 - f * r1) / (m22 - f * m12)
    r[1] = (r1 - m12 * r[2]) / m11
    r[0] = (r[0] - m[0, 1] * r[1] - m[0, 2] * r[2]) / m[0, 0]
