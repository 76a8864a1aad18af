"""One step of the cell under one control: exponential collocation at the Radau IIA nodes.

The one unknown is the main current as a function of time. Given its values at the three nodes, depth of discharge
follows by quadrature, every relaxation exactly for a forcing quadratic in time, and one scalar equation per node says
what the control asks: that current, that voltage or that power.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.charge.correction import correct
from pipeline.charge.gains import finish
from pipeline.charge.lanes import put
from pipeline.charge.moment import circuit_at
from pipeline.charge.nodes import circuit_near, close, follow_hysteresis, move, relax, warm
from pipeline.charge.state import (
    CURRENT_CONTROL,
    DEPTH,
    MAIN,
    NEAR,
    SIDE_SLOPE,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Run,
)
from pipeline.jit import inlined, kernel

_ITERATIONS = 14
# Corrections after which an iteration ends: the next would be their square; node temperatures act on voltages only.
_NEWTON = 1e-6
_WARMING_K = 1e-6
_WEAK = 1e-3
_ROUNDING = 1e-9


@kernel
def integrate(
    cell: Cell,
    run: Run,
    slot: int,
    control: int,
    target: float,
    bypassed: bool,
    ambient_k: float,
) -> bool:
    """Take one step; True when it converged with 1 - SOC above zero.

    Arguments
    ---------
    run : `at[MAIN, :3]` and `at[T, :3]` hold the guess on entry, the solution on return; `end` and `gain` are written.
    target : current [A] and power [W] of the battery, or voltage [V] of one cell.
    bypassed : the acceptance pair is discharged and the current is not charging it.
    """
    at, main, missed = run.at, run.at[MAIN], run.residual
    per_charge = run.length_s[slot] / cell.charge_as
    for _ in range(_ITERATIONS):
        run.near = per_charge * _largest(main) < NEAR * run.state[DEPTH]
        if not move(run, per_charge):
            return False
        if run.near:
            circuit_near(cell, run, per_charge)
        else:
            for j in range(3):
                circuit_at(cell, run, j)
        if cell.hysteresis == 1:
            follow_hysteresis(cell, run)
        relax(cell, run, slot, bypassed)
        close(cell, run, control, target, run.near)
        weak = control == CURRENT_CONTROL and cell.transfer == 0 and _coupling(cell, run, slot) < _WEAK
        if not weak:
            correct(cell, run, slot, control, bypassed)
        # A main current far below the total is a difference of two that are not: known to their rounding only.
        largest = _largest(main) + _ROUNDING * _largest(at[TOTAL]) + 1e-300
        worst = _largest(missed)
        if not math.isfinite(missed[0] + missed[1] + missed[2]):
            return False
        put(main, main[0] - missed[0], main[1] - missed[1], main[2] - missed[2], main[3] - missed[3])
        warmed = warm(cell, run, slot, ambient_k)
        if worst < _NEWTON * largest and warmed < _WARMING_K:
            finish(cell, run, slot, bypassed, ambient_k)
            if control == VOLTAGE_CONTROL:
                put(at[TERMINAL_V], target, target, target, at[TERMINAL_V, 3])
            return True
    return False


@inlined
def _coupling(cell: Cell, run: Run, slot: int) -> float:
    """Return about how much of a change of the main currents comes back through the side reaction."""
    resistance = 0.0
    for k in range(cell.pairs + cell.acceptance):
        # What the nodes do not hand to the end is left of the start.
        resistance += (1.0 - run.decay[slot, k, 2]) * run.resistance[k, 2]
    return float(resistance * _largest(run.at[SIDE_SLOPE]))


@inlined
def _largest(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude over the nodes."""
    return float(max(abs(values[0]), max(abs(values[1]), abs(values[2]))))
