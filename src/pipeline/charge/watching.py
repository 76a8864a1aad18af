"""What a charger of nickel cells watches: the voltage falling from its peak, and how fast the battery warms."""

from __future__ import annotations

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import LAGRANGE
from pipeline.charge.moment import node_heat
from pipeline.charge.state import HEAT, RELAXATIONS, START, TERMINAL_V, Run, T
from pipeline.jit import kernel

NO_PEAK = -1e300


@kernel
def renew_peak(run: Run, current_a: float) -> None:
    """Forget the peak where the current is lowered: the voltage that falls then says nothing of the battery."""
    if current_a < run.peak_a:
        run.peak_v = NO_PEAK
    run.peak_a = current_a


@kernel
def look_at_start(cell: Cell, run: Run, ambient_k: float) -> None:
    """Put the net heat at the start of a step beside that at its nodes [W]."""
    if cell.recombination == 1:
        run.value[cell.relaxations - 1, START] = run.state[RELAXATIONS + cell.relaxations - 1]
    lost = (run.at[T, START] - ambient_k) / cell.thermal_resistance_k_w
    run.at[HEAT, START] = node_heat(cell, run, START) - lost


@kernel
def peak_until(run: Run, j: int) -> float:
    """Return the highest voltage of a cell up to moment j of a step; over a whole step, also between its nodes [V]."""
    v = run.at[TERMINAL_V]
    highest = max(run.peak_v, v[START])
    if j == START:
        return float(highest)
    for k in range(j + 1):
        highest = max(highest, v[k])
    if j == 2:
        level = LAGRANGE[0, 0] * v[0] + LAGRANGE[0, 1] * v[1] + LAGRANGE[0, 2] * v[2]
        slope = LAGRANGE[1, 0] * v[0] + LAGRANGE[1, 1] * v[1] + LAGRANGE[1, 2] * v[2]
        bend = LAGRANGE[2, 0] * v[0] + LAGRANGE[2, 1] * v[1] + LAGRANGE[2, 2] * v[2]
        if bend < 0.0 < slope < -2.0 * bend:
            highest = max(highest, level - 0.25 * slope * slope / bend)
    return float(highest)


@kernel
def watched_guard(cell: Cell, run: Run, charging: bool, drop_v: float, rate_k_s: float, j: int) -> tuple[float, bool]:
    """Return how far moment j is from the nearer of the two, and whether that is the falling voltage.

    Arguments
    ---------
    drop_v : how far the voltage of one cell may fall below its peak [V]; infinite where nobody asks.
    rate_k_s : how fast the battery may warm [K/s]; its heat over its heat capacity, nothing is differenced.
    """
    warming = rate_k_s - run.at[HEAT, j] / cell.heat_capacity_j_k
    if not charging:
        return warming, False
    falling = run.at[TERMINAL_V, j] - (peak_until(run, j) - drop_v)
    return min(falling, warming), falling < warming
