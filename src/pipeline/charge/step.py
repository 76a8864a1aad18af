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
from pipeline.cell.relaxation import RADAU
from pipeline.charge.correction import correct
from pipeline.charge.gains import finish
from pipeline.charge.moment import circuit_at, circuit_near, finish_moment, node_heat
from pipeline.charge.state import (
    CURRENT_CONTROL,
    DEPTH,
    HEAT,
    MAIN,
    RELAXATIONS,
    SIDE,
    SIDE_SLOPE,
    TEMPERATURE,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Run,
    T,
    X,
)
from pipeline.jit import inlined, kernel

_ITERATIONS = 14
# Corrections after which an iteration ends: the next would be their square; node temperatures act on voltages only.
_NEWTON = 1e-6
_WARMING_K = 1e-6
_WEAK = 1e-3
_ROUNDING = 1e-9
# Share of 1 - SOC that a step may move for straight lines to follow every curve, its square being nothing.
_NEAR = 1e-5


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
    at, state = run.at, run.state
    h = run.length_s[slot]
    per_charge = h / cell.charge_as
    voltages = cell.pairs + cell.acceptance
    for _ in range(_ITERATIONS):
        near = per_charge * _largest(at[MAIN]) < _NEAR * state[DEPTH]
        for j in range(3):
            drawn = RADAU[j, 0] * at[MAIN, 0] + RADAU[j, 1] * at[MAIN, 1] + RADAU[j, 2] * at[MAIN, 2]
            at[X, j] = state[DEPTH] - per_charge * drawn
            if not at[X, j] > 0.0:
                return False
            if near:
                circuit_near(cell, run, j)
            else:
                circuit_at(cell, run, j)
            for k in range(voltages):
                run.forcing[k, j] = run.resistance[k, j] * at[MAIN, j]
        if bypassed:
            for j in range(3):
                run.forcing[cell.pairs, j] = 0.0
        worst = 0.0
        for j in range(3):
            relaxed = 0.0
            for k in range(voltages):
                w = run.node[slot, k, j]
                run.value[k, j] = (
                    run.decay[slot, k, j] * state[RELAXATIONS + k]
                    + w[0] * run.forcing[k, 0]
                    + w[1] * run.forcing[k, 1]
                    + w[2] * run.forcing[k, 2]
                )
                relaxed += run.value[k, j]
            run.residual[j], _ = finish_moment(cell, run, j, relaxed, control, target)
        weak = control == CURRENT_CONTROL and cell.transfer == 0 and _coupling(cell, run, slot) < _WEAK
        if not weak:
            correct(cell, run, slot, control, bypassed)
        # A main current far below the total is a difference of two that are not: known to their rounding only.
        largest = _largest(at[MAIN]) + _ROUNDING * _largest(at[TOTAL]) + 1e-300
        for j in range(3):
            change = run.residual[j]
            if not math.isfinite(change):
                return False
            at[MAIN, j] -= change
            worst = max(worst, abs(change) / largest)
        warmed = _heat_nodes(cell, run, slot, ambient_k)
        if worst < _NEWTON and warmed < _WARMING_K:
            finish(cell, run, slot, bypassed, ambient_k)
            if control == VOLTAGE_CONTROL:
                for j in range(3):
                    at[TERMINAL_V, j] = target
            return True
    return False


@inlined
def _heat_nodes(cell: Cell, run: Run, slot: int, ambient_k: float) -> float:
    """Move the node temperatures to what the heat at the nodes makes of them; return the largest change [K]."""
    at, state = run.at, run.state
    h = run.length_s[slot]
    if cell.recombination == 1:
        k = cell.relaxations - 1
        for j in range(3):
            w = run.node[slot, k, j]
            run.value[k, j] = (
                run.decay[slot, k, j] * state[RELAXATIONS + k]
                + w[0] * at[SIDE, 0]
                + w[1] * at[SIDE, 1]
                + w[2] * at[SIDE, 2]
            )
    for j in range(3):
        at[HEAT, j] = node_heat(cell, run, j) - (at[T, j] - ambient_k) / cell.thermal_resistance_k_w
    largest = 0.0
    for j in range(3):
        warming = RADAU[j, 0] * at[HEAT, 0] + RADAU[j, 1] * at[HEAT, 1] + RADAU[j, 2] * at[HEAT, 2]
        temperature = state[TEMPERATURE] + h / cell.heat_capacity_j_k * warming
        largest = max(largest, abs(temperature - at[T, j]))
        at[T, j] = temperature
    return largest


@inlined
def _coupling(cell: Cell, run: Run, slot: int) -> float:
    """Return about how much of a change of the main currents comes back through the side reaction."""
    resistance = 0.0
    for k in range(cell.pairs + cell.acceptance):
        w = run.node[slot, k, 2]
        resistance += (w[0] + w[1] + w[2]) * run.resistance[k, 2]
    return float(resistance * _largest(run.at[SIDE_SLOPE]))


@inlined
def _largest(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude over the nodes."""
    return float(max(abs(values[0]), abs(values[1]), abs(values[2])))
