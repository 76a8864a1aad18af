"""A whole segment in closed form, where all of its current is the main current and nothing can happen in it.

Without side reaction, charge transfer, hysteresis and acceptance pair a constant current stays one, and a segment moves
SOC so little that every curve is a straight line over it: what drives a pair is linear in time, its voltage follows
exactly, and what it takes and does not store it turns into heat. Everything else is for the steps of `step`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ENTROPIC, FIRST_PAIR, OPEN_CIRCUIT, REFERENCE_K, SERIES, Cell
from pipeline.cell.curves import value_and_slope
from pipeline.cell.relaxation import phi_functions
from pipeline.charge.record_keeping import Book, add_plain, passes_mark
from pipeline.charge.segment import ROUNDING, STAGE_EDGE
from pipeline.charge.state import (
    CHARGE,
    DEPTH,
    ELECTRICAL,
    NEAR,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    TEMPERATURE,
    TO_AMBIENT,
    VOLTAGE_TIME,
    Demand,
    Run,
    lift_at,
)
from pipeline.jit import inlined, kernel

# Share of the thermal time constant that a segment may last: its temperature is a straight line.
BRIEF = 1e-4


@inlined
def is_plain(cell: Cell) -> bool:
    """Tell whether all current of a cell is its main current, and no part of its voltage bends with it."""
    others = cell.side + cell.transfer + cell.hysteresis + cell.acceptance + cell.thermoneutral
    return bool(others + cell.warming == 0)


@inlined
def cross(
    cell: Cell, run: Run, book: Book, demand: Demand, limits: NDArray[np.float64], ambient_k: float, length_s: float
) -> bool:
    """Cross the segment that the run is at; False, and nothing done, where something may happen in it.

    The cell must be plain, and nothing that has its time may fall due in the segment.
    """
    state, end, gain, current = run.state, run.end, run.gain, demand.current_a
    moved = -current * length_s * cell.per_as
    end[DEPTH] = state[DEPTH] + moved
    if (
        abs(moved) >= NEAR * state[DEPTH]
        or length_s > BRIEF * cell.heat_capacity_j_k * cell.thermal_resistance_k_w
        or end[DEPTH] < max(limits[0], max(limits[4], limits[STAGE_EDGE]))
        or passes_mark(book, end[DEPTH])
    ):
        return False
    middle = state[DEPTH] + 0.5 * moved
    open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, middle)
    entropy, entropy_slope = value_and_slope(cell, ENTROPIC, middle)
    ohm, ohm_slope = value_and_slope(cell, SERIES, middle)
    before_v, after_v, highest_v, passed_vs, pair_j = _follow_pairs(cell, run, current, middle, moved, length_s)
    # The battery's heat at the temperature of the start, then at that of the middle.
    # Reciprocals, for what is divided waits for nothing else.
    start_k, loss, per_j = state[TEMPERATURE], 1.0 / cell.thermal_resistance_k_w, 1.0 / cell.heat_capacity_j_k
    series_j, reversible_jk = ohm * current * current * length_s, current * entropy * length_s
    heat_j = cell.cells * (series_j + pair_j + reversible_jk * start_k)
    half_k = 0.5 * (heat_j - (start_k - ambient_k) * loss * length_s) * per_j
    reversible_j = reversible_jk * (start_k + half_k)
    ambient_j = (start_k + half_k - ambient_k) * loss * length_s
    heat_j = cell.cells * (series_j + pair_j + reversible_j)
    end[TEMPERATURE] = start_k + (heat_j - ambient_j) * per_j
    slow_v = open_v + entropy * (start_k + half_k - REFERENCE_K) + ohm * current
    by_depth = open_slope + entropy_slope * (start_k - REFERENCE_K) + ohm_slope * current
    drift_v = 0.5 * moved * by_depth + entropy * half_k
    highest_v += slow_v + abs(drift_v)
    allowed_v = min(limits[1], limits[5]) * (1.0 - ROUNDING)
    if demand.charging:
        allowed_v = min(allowed_v, demand.limit_v)
        if cell.cells * highest_v * current > demand.power_w:
            return False
    end_k = end[TEMPERATURE]
    lift_v = min(lift_at(demand, start_k), lift_at(demand, end_k))
    if highest_v > allowed_v + lift_v or max(start_k, end_k) > min(limits[3], limits[7]):
        return False
    if end_k > demand.highest_k or end_k < demand.lowest_k:
        return False
    gain[CHARGE], gain[TO_AMBIENT] = current * length_s, ambient_j
    gain[VOLTAGE_TIME] = cell.cells * (slow_v * length_s + passed_vs)
    gain[ELECTRICAL] = gain[VOLTAGE_TIME] * current
    gain[SERIES_HEAT], gain[REVERSIBLE_HEAT] = cell.cells * series_j, cell.cells * reversible_j
    add_plain(cell, run, book, current, length_s, before_v + slow_v - drift_v, after_v + slow_v + drift_v)
    for part in range(RELAXATIONS + cell.pairs):
        state[part] = end[part]
    return True


@inlined
def _follow_pairs(
    cell: Cell, run: Run, current: float, middle: float, moved: float, length_s: float
) -> tuple[float, float, float, float, float]:
    """Write the pairs' voltages at the end and their heat; return what they come to.

    Returns
    -------
    Sums over the pairs of one cell: voltage at the start, at the end, the higher of both [V], their integral [V s],
    heat [J].
    """
    state, end, gain, weights = run.state, run.end, run.gain, run.plain[run.segment]
    if run.plain_s[run.segment] != length_s:
        _weigh(cell, run, length_s)
    before_v = after_v = highest_v = passed_vs = heat_j = 0.0
    for k in range(cell.pairs):
        resistance, slope = value_and_slope(cell, FIRST_PAIR + k, middle)
        half_ohm = 0.5 * slope * moved
        first_v, rise_v = (resistance - half_ohm) * current, 2.0 * half_ohm * current
        v, w = state[RELAXATIONS + k], weights[k]
        after = w[0] * v + w[1] * first_v + w[2] * rise_v
        passed = w[3] * v + w[4] * first_v + w[5] * rise_v
        heat = current * passed
        if resistance > 0.0:
            stored = after * after / (resistance + half_ohm) - v * v / (resistance - half_ohm)
            heat -= 0.5 * cell.tau_s[k] * stored
        end[RELAXATIONS + k], gain[PAIR_HEAT + k] = after, cell.cells * heat
        before_v, after_v, highest_v = before_v + v, after_v + after, highest_v + max(v, after)
        passed_vs, heat_j = passed_vs + passed, heat_j + heat
    return before_v, after_v, highest_v, passed_vs, heat_j


@kernel
def _weigh(cell: Cell, run: Run, length_s: float) -> None:
    """Write how the pairs follow over a segment: at its end, and in the integral, for start, step and ramp."""
    phi = run.phi
    run.plain_s[run.segment] = length_s
    for k in range(cell.pairs):
        z, w = length_s / cell.tau_s[k], run.plain[run.segment, k]
        phi_functions(-z, 3, phi)
        w[0], w[1], w[2] = phi[0], z * phi[1], z * phi[2]
        w[3], w[4], w[5] = length_s * phi[1], length_s * z * phi[2], length_s * z * phi[3]
