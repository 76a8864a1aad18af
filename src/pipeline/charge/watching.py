"""What a charger of nickel cells watches: the voltage falling from its peak, and how fast the battery warms."""

from __future__ import annotations

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import LAGRANGE
from pipeline.charge.nodes import of_stores
from pipeline.charge.state import (
    BLOCKED,
    ENTROPY,
    ETA,
    HEAT,
    HYSTERESIS_V,
    MAIN,
    NODE_V,
    OHM,
    POWER_CONTROL,
    RELAXATIONS,
    SIDE,
    SLOW_V,
    START,
    TERMINAL_V,
    TOTAL,
    Run,
    T,
)
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
    """Keep the net heat at the start of a step, whose circuit is solved; its nodes have theirs from the step."""
    at, main = run.at, run.at[MAIN, START]
    if cell.thermoneutral == 1:
        heat = main * (at[SLOW_V, START] - cell.thermoneutral_v)
    else:
        heat = main * (at[T, START] * at[ENTROPY, START] + at[HYSTERESIS_V, START])
    heat += at[OHM, START] * at[TOTAL, START] ** 2 + at[ETA, START] * main
    heat += at[SIDE, START] * (at[NODE_V, START] - cell.gas_v)
    for k in range(cell.pairs + cell.acceptance):
        inverse = run.inverse[k, START]
        drift = 0.5 * cell.tau_s[k] * cell.per_as * run.slope[k, START] * inverse * main
        heat += run.state[RELAXATIONS + k] ** 2 * (1.0 - drift) * inverse
    if cell.recombination == 1:
        heat += run.state[RELAXATIONS + cell.relaxations - 1] * cell.gas_v
    run.start_heat_w = cell.cells * heat - (at[T, START] - ambient_k) / cell.thermal_resistance_k_w
    if cell.warming == 1:
        run.start_heat_w *= of_stores(cell, run, START)


@kernel
def peak_until(run: Run, j: int) -> float:
    """Return the highest voltage of a cell up to moment j of a step; over a whole step, also between its nodes [V].

    There is none while the supply is the limit, which lowers the current, and the voltage with it, as the sun does; nor
    while the charger is blocked.
    """
    if run.control == BLOCKED or (run.control == POWER_CONTROL and run.supplied):
        return NO_PEAK
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
    heat_w = run.start_heat_w if j == START else run.at[HEAT, j]
    warming = rate_k_s - heat_w / cell.heat_capacity_j_k
    if not charging or run.control == BLOCKED or (run.control == POWER_CONTROL and run.supplied):
        return warming, False
    falling = run.at[TERMINAL_V, j] - (peak_until(run, j) - drop_v)
    return min(falling, warming), falling < warming
