"""The error estimate of a step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import AT_START
from pipeline.charge.state import ENTROPY, ETA, MAIN, OHM, SLOW_V, START, TOTAL, Run, T
from pipeline.jit import inlined

# A current the step cannot follow leaves this share of its squared mismatch behind, measured and rounded upwards.
CURRENT_ERROR = 1e-3
# A voltage it cannot follow: this share of its mismatch, rounded upwards.
_VOLTAGE_ERROR = 0.1


@inlined
def step_error(cell: Cell, run: Run, h: float, bypassed: bool) -> float:
    """Return the local error of a step in units of the battery's own scales, per unit of tolerance 1.

    Each function of time that the step replaces by a quadratic is extrapolated back to the start, where it is known.
    The current's mismatch grows as h^3, its effect on the end of the step as h^6: hence the square.
    """
    at = run.at
    main = _mismatch(at[MAIN])
    swing = max(abs(at[MAIN, START] - at[MAIN, 2]), abs(at[MAIN, 0] - at[MAIN, 2])) + abs(main) + 1e-300
    flow = abs(at[TOTAL, 2]) + 1e-3 * cell.charge_as / 3600.0
    error = CURRENT_ERROR * main * main / (swing * flow)
    if run.near and cell.transfer == 0 and cell.hysteresis == 0:
        # Every other quantity is a straight line by construction.
        return float(error)
    voltage = abs(_mismatch(at[SLOW_V])) + abs(at[T, START] * _mismatch(at[ENTROPY]))
    if cell.transfer == 1:
        voltage += abs(_mismatch(at[ETA]))
    voltage += abs(_mismatch(at[OHM])) * flow
    for k in range(cell.pairs + cell.acceptance):
        if bypassed and k == cell.pairs:
            continue
        mismatch = _mismatch(run.resistance[k]) * at[MAIN, 2]
        voltage += abs(mismatch) * min(1.0, h / cell.tau_s[k])
    return float(max(error, _VOLTAGE_ERROR * voltage / at[SLOW_V, 2]))


@inlined
def _mismatch(values: NDArray[np.float64]) -> float:
    """Return the quadratic through the nodes extrapolated to the start, less the value there."""
    return float(AT_START[0] * values[0] + AT_START[1] * values[1] + AT_START[2] * values[2] - values[START])
