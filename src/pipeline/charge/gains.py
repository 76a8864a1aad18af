"""The end of a step and what it adds: charge, energy, heat by path."""

from __future__ import annotations

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import RADAU
from pipeline.charge.state import (
    CHARGE,
    DEPTH,
    ELECTRICAL,
    ETA,
    MAIN,
    OHM,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE,
    SIDE_CHARGE,
    SIDE_HEAT,
    SLOW_V,
    TEMPERATURE,
    TO_AMBIENT,
    TOTAL,
    TRANSFER_HEAT,
    VOLTAGE_TIME,
    Run,
    T,
)
from pipeline.jit import inlined


@inlined
def finish(cell: Cell, run: Run, slot: int, bypassed: bool, ambient_k: float) -> None:
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

    int v^2 dt = int v g dt - (tau/2) change of v^2; what the slow factor 1/R changes over the step meets
    v exactly once and once by its values at the nodes.
    """
    at, gain, n = run.at, run.gain, cell.cells
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
        run.row[j] = part
        gain[VOLTAGE_TIME] += n * part
        gain[ELECTRICAL] += n * part * at[TOTAL, j]
        gain[SIDE_HEAT] += n * part * at[SIDE, j]
        squared += part * run.resistance[k, j] * at[MAIN, j]
        mean += RADAU[2, j] * run.conductance[k, j]
    heat = mean * squared
    for j in range(3):
        heat += run.row[j] * run.value[k, j] * (run.conductance[k, j] - mean)
    gain[PAIR_HEAT + k] = n * heat
    return float(n * heat)
