"""One step of the cell under one control: exponential collocation at the Radau IIA nodes.

The one unknown is the main current as a function of time. Given its values at the three nodes, depth of discharge
follows by quadrature, every relaxation exactly for a forcing quadratic in time, and one scalar equation per node says
what the control asks: that current, that voltage or that power. Newton's method solves them; the error estimate
compares the quadratics with the start of the step.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import REFERENCE_K, Cell
from pipeline.cell.relaxation import AT_START, MOST_SLOTS, NODES, PASSED, fill
from pipeline.charge.moment import circuit_at
from pipeline.charge.nodes import circuit_near, close, follow_hysteresis, move, relax, warm
from pipeline.charge.state import (
    CURRENT_CONTROL,
    DEPTH,
    ENTROPY,
    ETA,
    ETA_BY_DEPTH,
    ETA_SLOPE,
    MAIN,
    NEAR,
    OHM,
    OHM_SLOPE,
    OPEN_SLOPE,
    POWER_CONTROL,
    SIDE,
    SIDE_SLOPE,
    SLOW_V,
    START,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Run,
    T,
    put,
)
from pipeline.jit import inlined, kernel


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


# A current the step cannot follow leaves this share of its squared mismatch behind, measured and rounded upwards.
CURRENT_ERROR = 1e-3
# From a supply at its limit the current is small in its swing, and what a fast pair does to it is the charge missed.
_POWER_ERROR = 3e-3
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
    if run.control == POWER_CONTROL:
        error = max(error, _POWER_ERROR * abs(main) / flow)
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
    run : `at[MAIN, :3]` and `at[T, :3]` hold the guess on entry, the solution on return; where the step ends and what
        it adds is for `energy.finish` to write.
    target : current [A] and power [W] of the battery, or voltage of one cell at 25 degC [V].
    bypassed : the acceptance pair is discharged and the current is not charging it.
    """
    at, main, side, missed = run.at, run.at[MAIN], run.at[SIDE], run.residual
    per_charge = run.length_s[slot] / cell.charge_as
    for _ in range(_ITERATIONS):
        run.near = cell.warming == 0 and per_charge * _largest(main) < NEAR * run.state[DEPTH]
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
        weak = control == CURRENT_CONTROL and cell.transfer == 0
        if weak and cell.side == 1:
            weak = _coupling(cell, run, slot) < _WEAK
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
            put(at[TOTAL], main[0] + side[0], main[1] + side[1], main[2] + side[2], at[TOTAL, START])
            if control == VOLTAGE_CONTROL:
                k, t = run.lift_v_k, at[T]
                a, b, c = t[0] - REFERENCE_K, t[1] - REFERENCE_K, t[2] - REFERENCE_K
                put(at[TERMINAL_V], target + k * a, target + k * b, target + k * c, at[TERMINAL_V, 3])
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


@inlined
def slot_of(cell: Cell, run: Run, length_s: float) -> int:
    """Return the slot that holds the weights of a step length, computing them where none does.

    What has served again stays for another round: lengths on the way to a crossing are there once.
    """
    lengths, served = run.length_s, run.served
    for slot in range(MOST_SLOTS):
        if lengths[slot] == length_s:
            served[slot] = 1
            return slot
    slot = run.next_slot
    while served[slot] == 1:
        served[slot] = 0
        slot = (slot + 1) % MOST_SLOTS
    run.next_slot = (slot + 1) % MOST_SLOTS
    fill(run, slot, length_s, cell.tau_s, cell.relaxations)
    return int(slot)


# Polynomials in the fraction of a step, less one, through its three nodes and, last, its start.
_AT_END = np.linalg.inv(np.vander(np.append(NODES, 0.0) - 1.0, increasing=True))
# Newton's corrections of where such a polynomial comes to zero.
_POLISHED = 12


@inlined
def crossing(gaps: NDArray[np.float64], at_start: float, share: float, before: float, beyond: float) -> float:
    """Return where the gap comes to so little below zero, in units of the length of the step tried last.

    From the cubic through its values at start and nodes of that step; its slope at the end is that which leads to the
    value of another length, so that the next guess misses by the product of the last two misses and more.

    Arguments
    ---------
    share, before : another length, in the same unit, and the gap there; a share of 1 where there is none.
    """
    one = two = three = 0.0
    for n in range(3):
        one, two, three = one + _AT_END[1, n] * gaps[n], two + _AT_END[2, n] * gaps[n], three + _AT_END[3, n] * gaps[n]
    one, two, three = one + _AT_END[1, 3] * at_start, two + _AT_END[2, 3] * at_start, three + _AT_END[3, 3] * at_start
    if share != 1.0:
        away = 1.0 - share
        one = (gaps[2] - before) / away + away * (two - away * three)
    shift = 0.0
    for _ in range(_POLISHED):
        miss = gaps[2] + beyond + shift * (one + shift * (two + shift * three))
        change = miss / (one + shift * (2.0 * two + 3.0 * shift * three))
        shift = max(shift - change, -1.0)
        if abs(change) <= 1e-9 * abs(shift):
            break
    return 1.0 + shift
