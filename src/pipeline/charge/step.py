"""One step of the cell under one control: exponential collocation at the Radau IIA nodes.

The one unknown is the main current as a function of time. Given its values at the three nodes, depth of discharge
follows by quadrature, every relaxation exactly for a forcing quadratic in time, and one scalar equation per node says
what the control asks: that current, that voltage or that power.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    ENTROPIC,
    EXCHANGE,
    FIRST_PAIR,
    MOST_RELAXATIONS,
    OPEN_CIRCUIT,
    REFERENCE_K,
    SERIES,
    THERMAL_V_PER_K,
    Cell,
    side_current,
)
from pipeline.cell.curves import value_and_slope
from pipeline.cell.relaxation import AT_START, RADAU, WEIGHT_FIELDS
from pipeline.jit import inlined, kernel

CURRENT_CONTROL, VOLTAGE_CONTROL, POWER_CONTROL = range(3)

# State of the battery: 1 - SOC, temperature [K], then the relaxations.
DEPTH, TEMPERATURE, RELAXATIONS = range(3)

# What a step adds, per battery; dissipation of the pairs follows.
(
    CHARGE,
    SIDE_CHARGE,
    VOLTAGE_TIME,
    ELECTRICAL,
    SERIES_HEAT,
    TRANSFER_HEAT,
    REVERSIBLE_HEAT,
    SIDE_HEAT,
    TO_AMBIENT,
    PAIR_HEAT,
) = range(10)

# Rows of the quantities at a moment: columns are the three nodes and, fourth, the start of the step.
(
    MAIN,
    SIDE,
    TOTAL,
    X,
    T,
    NODE_V,
    SLOW_V,
    OHM,
    ETA,
    ENTROPY,
    REVERSIBLE,
    HEAT,
    TERMINAL_V,
    SIDE_SLOPE,
    ETA_SLOPE,
    QUANTITIES,
) = range(16)
START = 3
_ITERATIONS = 14
# Corrections after which an iteration ends: the next would be their square; node temperatures act on voltages only.
_NEWTON = 1e-8
_WARMING_K = 1e-6
# A current the step cannot follow leaves this share of its squared mismatch behind, measured and rounded upwards.
_CURRENT_ERROR = 1e-3


RUN = np.dtype(
    [
        ("state", np.float64, (RELAXATIONS + MOST_RELAXATIONS,)),
        ("end", np.float64, (RELAXATIONS + MOST_RELAXATIONS,)),
        ("gain", np.float64, (PAIR_HEAT + MOST_RELAXATIONS,)),
        ("at", np.float64, (QUANTITIES, 4)),
        ("forcing", np.float64, (MOST_RELAXATIONS, 4)),
        ("value", np.float64, (MOST_RELAXATIONS, 4)),
        ("resistance", np.float64, (MOST_RELAXATIONS, 4)),
        ("slope", np.float64, (MOST_RELAXATIONS, 4)),
        ("conductance", np.float64, (MOST_RELAXATIONS, 4)),
        ("depth_slope", np.float64, (3, 4)),
        ("jacobian", np.float64, (3, 3)),
        ("residual", np.float64, (3,)),
        ("proposal_s", np.float64, (3, 3)),
        ("guess_a", np.float64),
        ("control", np.int64),
        ("bypassed", np.int64),
        ("next_slot", np.int64),
        ("steps", np.int64),
        ("edges", np.int64),
        ("changes", np.int64),
        *WEIGHT_FIELDS,
    ],
    align=True,
)
"""Everything of a run that changes, in one record: nothing is allocated in a step."""

Run = Any


def new_run() -> Run:
    """Return the record of a run that has not begun."""
    run = np.zeros(1, dtype=RUN).view(np.recarray)[0]
    run["length_s"][:] = -1.0
    return run


# Rows of the slopes with x.
_OPEN_SLOPE, _OHM_SLOPE, _ETA_SLOPE = range(3)


@inlined
def circuit_at(cell: Cell, run: Run, j: int) -> None:
    """Evaluate at moment j everything that depends on SOC alone, and its slope with x."""
    at, slope = run.at, run.depth_slope
    x = at[X, j]
    open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, x)
    entropy, entropy_slope = value_and_slope(cell, ENTROPIC, x)
    warmer = at[T, j] - REFERENCE_K
    at[SLOW_V, j] = open_v + entropy * warmer
    at[ENTROPY, j] = entropy
    slope[_OPEN_SLOPE, j] = open_slope + entropy_slope * warmer
    at[OHM, j], slope[_OHM_SLOPE, j] = value_and_slope(cell, SERIES, x)
    for k in range(cell.pairs):
        run.resistance[k, j], run.slope[k, j] = value_and_slope(cell, FIRST_PAIR + k, x)
    if cell.acceptance == 1:
        k = cell.pairs
        run.resistance[k, j] = cell.acceptance_ohm / x
        run.slope[k, j] = -run.resistance[k, j] / x


@inlined
def charge_transfer(cell: Cell, x: float, temperature_k: float, main_a: float) -> tuple[float, float, float]:
    """Return the overpotential (2RT/F) asinh(i / 2 i0) [V] and its slopes with current and with x."""
    if cell.transfer == 0:
        return 0.0, 0.0, 0.0
    exchange, exchange_slope = value_and_slope(cell, EXCHANGE, x)
    scale = 2.0 * THERMAL_V_PER_K * temperature_k
    with_current = scale / math.hypot(main_a, 2.0 * exchange)
    overpotential = scale * math.asinh(main_a / (2.0 * exchange))
    return overpotential, with_current, -with_current * main_a / exchange * exchange_slope


@inlined
def finish_moment(cell: Cell, run: Run, j: int, relaxed_v: float, control: int, target: float) -> tuple[float, float]:
    """Evaluate moment j for its main current; return the control's residual and its slope with that current alone."""
    at = run.at
    eta, eta_slope, run.depth_slope[_ETA_SLOPE, j] = charge_transfer(cell, at[X, j], at[T, j], at[MAIN, j])
    node_v = at[SLOW_V, j] + relaxed_v + eta
    side, side_slope = side_current(cell, node_v, at[T, j])
    total = at[MAIN, j] + side
    terminal_v = node_v + at[OHM, j] * total
    at[ETA, j], at[NODE_V, j], at[SIDE, j], at[SIDE_SLOPE, j] = eta, node_v, side, side_slope
    at[TOTAL, j], at[TERMINAL_V, j], at[ETA_SLOPE, j] = total, terminal_v, eta_slope
    total_slope = 1.0 + side_slope * eta_slope
    if control == CURRENT_CONTROL:
        return total - target, total_slope
    if control == VOLTAGE_CONTROL:
        return terminal_v - target, eta_slope + at[OHM, j] * total_slope
    slope = (eta_slope + at[OHM, j] * total_slope) * total + terminal_v * total_slope
    return terminal_v * total - target, slope


@kernel
def solve_start(cell: Cell, run: Run, control: int, target: float, guess: float) -> bool:
    """Solve the circuit for the state as it stands and fill the start column; False where that fails.

    The residual rises with the current and bends upwards, so Newton's iteration cannot circle.
    """
    at, state = run.at, run.state
    at[X, START], at[T, START] = state[DEPTH], state[TEMPERATURE]
    circuit_at(cell, run, START)
    relaxed = 0.0
    for k in range(cell.pairs + cell.acceptance):
        relaxed += state[RELAXATIONS + k]
        run.value[k, START] = state[RELAXATIONS + k]
    at[MAIN, START] = guess
    scale = abs(target) + 1e-9
    for _ in range(400):
        residual, slope = finish_moment(cell, run, START, relaxed, control, target)
        if not math.isfinite(residual):
            return False
        change = residual / slope
        if abs(residual) <= 2e-15 * scale or abs(change) <= 1e-16 * abs(at[MAIN, START]):
            return True
        at[MAIN, START] -= change
        if abs(change) <= 1e-9 * abs(at[MAIN, START]):
            finish_moment(cell, run, START, relaxed, control, target)
            return True
    return False


@inlined
def node_heat(cell: Cell, run: Run, j: int) -> float:
    """Return the heat of the whole battery at moment j [W], the relaxation of gas left out."""
    at = run.at
    main = at[MAIN, j]
    if cell.thermoneutral == 1:
        reversible = main * (at[SLOW_V, j] - cell.thermoneutral_v)
    else:
        reversible = main * at[T, j] * at[ENTROPY, j]
    at[REVERSIBLE, j] = reversible
    heat = reversible + at[OHM, j] * at[TOTAL, j] ** 2 + at[ETA, j] * main + at[SIDE, j] * (at[NODE_V, j] - cell.gas_v)
    for k in range(cell.pairs + cell.acceptance):
        run.conductance[k, j] = pair_conductance(cell, run, k, j)
        heat += run.value[k, j] ** 2 * run.conductance[k, j]
    if cell.recombination == 1:
        heat += run.value[cell.relaxations - 1, j] * cell.gas_v
    return cell.cells * heat


@inlined
def pair_conductance(cell: Cell, run: Run, k: int, j: int) -> float:
    """Return what turns v^2 into the heat of pair k: 1/R - (dC/dt)/2 with C = tau / R [S]."""
    if run.resistance[k, j] <= 0.0:
        return 0.0
    conductance = 1.0 / run.resistance[k, j]
    if run.slope[k, j] == 0.0:
        return conductance
    drift = 0.5 * cell.tau_s[k] * run.slope[k, j] * conductance * run.at[MAIN, j] / cell.charge_as
    return (1.0 - drift) * conductance


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
        for j in range(3):
            drawn = RADAU[j, 0] * at[MAIN, 0] + RADAU[j, 1] * at[MAIN, 1] + RADAU[j, 2] * at[MAIN, 2]
            at[X, j] = state[DEPTH] - per_charge * drawn
            if not at[X, j] > 0.0:
                return False
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
        _newton(cell, run, slot, control, bypassed)
        largest = max(abs(at[MAIN, 0]), abs(at[MAIN, 1]), abs(at[MAIN, 2])) + 1e-300
        for j in range(3):
            change = run.residual[j]
            if not math.isfinite(change):
                return False
            at[MAIN, j] -= change
            worst = max(worst, abs(change) / largest)
        warmed = _heat_nodes(cell, run, slot, ambient_k)
        if worst < _NEWTON and warmed < _WARMING_K:
            _finish(cell, run, slot, bypassed, ambient_k)
            if control == VOLTAGE_CONTROL:
                for j in range(3):
                    at[TERMINAL_V, j] = target
            return True
    return False


@inlined
def _newton(cell: Cell, run: Run, slot: int, control: int, bypassed: bool) -> None:
    """Replace the residuals of the nodes by Newton's corrections of their main currents."""
    at, m = run.at, run.jacobian
    per_charge = run.length_s[slot] / cell.charge_as
    for j in range(3):
        with_x = run.depth_slope[_OPEN_SLOPE, j] + run.depth_slope[_ETA_SLOPE, j]
        for n in range(3):
            # Through the forcing of node n: by its current, and by its x in every forcing that depends on it.
            run.row[n] = 0.0
            m[j, n] = 0.0
            for k in range(cell.pairs + cell.acceptance):
                if not (bypassed and k == cell.pairs):
                    m[j, n] += run.node[slot, k, j, n] * run.resistance[k, n]
                    run.row[n] += run.node[slot, k, j, n] * run.slope[k, n]
            run.row[n] *= at[MAIN, n]
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
            ohm_drift = per_charge * RADAU[j, n] * run.depth_slope[_OHM_SLOPE, j] * at[TOTAL, j]
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
def _finish(cell: Cell, run: Run, slot: int, bypassed: bool, ambient_k: float) -> None:
    """Write the state at the end and what the step adds, exact for quadratic currents and exponential voltages."""
    at, gain, end, state = run.at, run.gain, run.end, run.state
    h = run.length_s[slot]
    for row in range(PAIR_HEAT + cell.pairs + cell.acceptance):
        gain[row] = 0.0
    n = cell.cells
    drawn = 0.0
    for j in range(3):
        b = h * RADAU[2, j]
        slow_v = at[SLOW_V, j] + at[ETA, j]
        total = at[MAIN, j] + at[SIDE, j]
        at[TOTAL, j] = total
        drawn += b * at[MAIN, j]
        gain[CHARGE] += b * total
        gain[SIDE_CHARGE] += b * at[SIDE, j]
        gain[VOLTAGE_TIME] += n * b * (slow_v + at[OHM, j] * total)
        gain[ELECTRICAL] += n * b * (slow_v + at[OHM, j] * total) * total
        gain[SERIES_HEAT] += n * b * at[OHM, j] * total * total
        gain[TRANSFER_HEAT] += n * b * at[ETA, j] * at[MAIN, j]
        gain[REVERSIBLE_HEAT] += n * b * at[REVERSIBLE, j]
        gain[SIDE_HEAT] += n * b * at[SIDE, j] * slow_v
        gain[TO_AMBIENT] += b * (at[T, j] - ambient_k) / cell.thermal_resistance_k_w
    end[DEPTH] = state[DEPTH] - drawn / cell.charge_as
    pair_heat = 0.0
    for k in range(cell.pairs + cell.acceptance):
        pair_heat += _finish_pair(cell, run, slot, k, state[RELAXATIONS + k], bypassed and k == cell.pairs)
    if cell.recombination == 1:
        k = cell.relaxations - 1
        w = run.node[slot, k, 2]
        before = state[RELAXATIONS + k]
        end[RELAXATIONS + k] = (
            run.decay[slot, k, 2] * before + w[0] * at[SIDE, 0] + w[1] * at[SIDE, 1] + w[2] * at[SIDE, 2]
        )
        gain[SIDE_HEAT] -= n * cell.gas_v * cell.tau_s[k] * (end[RELAXATIONS + k] - before)
    heat = gain[SERIES_HEAT] + gain[TRANSFER_HEAT] + gain[REVERSIBLE_HEAT] + gain[SIDE_HEAT] + pair_heat
    end[TEMPERATURE] = state[TEMPERATURE] + (heat - gain[TO_AMBIENT]) / cell.heat_capacity_j_k


@inlined
def _finish_pair(cell: Cell, run: Run, slot: int, k: int, before: float, bypassed: bool) -> float:
    """Advance one pair and add its work and heat; return its heat [J] for the battery.

    int v^2 dt = int v g dt - (tau/2) change of v^2; the slow factor's change over the step is taken by the nodes.
    """
    at, gain, n = run.at, run.gain, cell.cells
    h = run.length_s[slot]
    if bypassed:
        run.end[RELAXATIONS + k] = 0.0
        return 0.0
    g0, g1, g2 = (
        run.resistance[k, 0] * at[MAIN, 0],
        run.resistance[k, 1] * at[MAIN, 1],
        run.resistance[k, 2] * at[MAIN, 2],
    )
    w = run.node[slot, k, 2]
    after = run.decay[slot, k, 2] * before + w[0] * g0 + w[1] * g1 + w[2] * g2
    run.end[RELAXATIONS + k] = after
    squared = -0.5 * cell.tau_s[k] * (after * after - before * before)
    mean = 0.0
    for j in range(3):
        m = run.moment[slot, k, j]
        part = run.start_moment[slot, k, j] * before + m[0] * g0 + m[1] * g1 + m[2] * g2
        gain[VOLTAGE_TIME] += n * part
        gain[ELECTRICAL] += n * part * at[TOTAL, j]
        gain[SIDE_HEAT] += n * part * at[SIDE, j]
        squared += part * run.resistance[k, j] * at[MAIN, j]
        mean += RADAU[2, j] * run.conductance[k, j]
    heat = mean * squared
    for j in range(3):
        heat += h * RADAU[2, j] * run.value[k, j] ** 2 * (run.conductance[k, j] - mean)
    gain[PAIR_HEAT + k] = n * heat
    return n * heat


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
    error = _CURRENT_ERROR * main * main / (swing * flow)
    voltage = abs(_mismatch(at[SLOW_V])) + abs(at[T, START] * _mismatch(at[ENTROPY]))
    if cell.transfer == 1:
        voltage += abs(_mismatch(at[ETA]))
    voltage += abs(_mismatch(at[OHM])) * flow
    for k in range(cell.pairs + cell.acceptance):
        if bypassed and k == cell.pairs:
            continue
        mismatch = _mismatch(run.resistance[k]) * at[MAIN, 2]
        voltage += abs(mismatch) * min(1.0, h / cell.tau_s[k])
    return max(error, 0.05 * voltage / at[SLOW_V, 2])


@inlined
def _mismatch(values: NDArray[np.float64]) -> float:
    """Return the quadratic through the nodes extrapolated to the start, less the value there."""
    return AT_START[0] * values[0] + AT_START[1] * values[1] + AT_START[2] * values[2] - values[START]
