"""A whole segment in closed form for a cell with a side reaction, where nothing can happen in it.

As in `plain`, with two differences. The main current is the constant total current less the side current, which is
taken as the quadratic through its values at the nodes of a step; and the acceptance pair is one of the pairs. The pairs
follow both exactly. The side current of the same segment a period ago is the first guess, and most often the last.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ENTROPIC, FIRST_PAIR, OPEN_CIRCUIT, REFERENCE_K, SERIES, Cell
from pipeline.cell.curves import value_and_slope
from pipeline.cell.relaxation import AT_START, LAGRANGE, NODES, RADAU, phi_functions, response
from pipeline.charge.nodes import SERIES_BELOW, growth
from pipeline.charge.plain import BRIEF
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
    SIDE_CHARGE,
    SIDE_HEAT,
    START,
    TEMPERATURE,
    TERMINAL_V,
    TO_AMBIENT,
    VOLTAGE_TIME,
    Demand,
    Run,
    lift_at,
    put,
)
from pipeline.charge.step import CURRENT_ERROR
from pipeline.jit import inlined, kernel

# Rows of a pair's weights: of its start, a constant and a rising drive, then of the side current at each node. Lanes
# are the three nodes of a step and, fourth, the mean over it.
_OF_START, _OF_STEP, _OF_RAMP, _OF_SIDE = range(4)
_MEAN = 3
_PASSES = 6
# Change of the side current, by the total, after which a pass is the last: the pairs have missed a share of it.
_SETTLED = 1e-9
_HIGHEST_EXPONENT = 300.0
_FIRST, _SECOND = float(NODES[0]), float(NODES[1])
_SHARES = (float(RADAU[2, 0]), float(RADAU[2, 1]), float(RADAU[2, 2]))
_BACK = (float(AT_START[0]), float(AT_START[1]), float(AT_START[2]))


class Leak(NamedTuple):
    """The side current of a cell at a moment [A], and its exponent's slopes with voltage [1/V] and warmth [1/K]."""

    current_a: float
    per_v: float
    per_k: float


class Lines(NamedTuple):
    """Side current at the start [A], what 1 - SOC moves by, and the straight lines that the curves are over it."""

    start_a: float
    moved: float
    open_v: float
    open_slope: float
    entropy: float
    entropy_slope: float
    ohm: float
    ohm_slope: float


class PairSums(NamedTuple):
    """Sums over the pairs of a cell, and the side charge.

    Mean voltage [V], heat and what the side current takes from them [J]; side charge, and its first moment about the
    middle in halves of the segment [A s].
    """

    passed_v: float
    heat_j: float
    leaked_j: float
    side_as: float
    later_as: float


@inlined
def is_leaking(cell: Cell) -> bool:
    """Tell whether a side reaction and an acceptance pair are all that bends a cell's answer to a current."""
    others = cell.transfer + cell.hysteresis + cell.recombination + cell.thermoneutral + cell.warming
    return bool(cell.side == 1 and others == 0)


@kernel
def leak_across(
    cell: Cell,
    run: Run,
    demand: Demand,
    limits: NDArray[np.float64],
    ambient_k: float,
    length_s: float,
    tolerance: float,
) -> bool:
    """Solve the segment that the run is at; False, and no state changed, where something may happen in it.

    The cell must be leaking, and nothing that has its time may fall due in the segment. End and gain of the run hold
    the result, and its terminal voltages at the start and at the end.
    """
    state, end, current = run.state, run.end, demand.current_a
    if (
        abs(current) * length_s * cell.per_as >= NEAR * state[DEPTH]
        or length_s > BRIEF * cell.heat_capacity_j_k * cell.thermal_resistance_k_w
        or (cell.acceptance == 1 and state[RELAXATIONS + cell.pairs] <= 0.0)
    ):
        return False
    if run.plain_s[run.segment] != length_s:
        _weigh(cell, run, length_s)
    allowed_v = min(limits[1], limits[5]) * (1.0 - ROUNDING)
    if demand.charging:
        allowed_v = min(allowed_v, demand.limit_v)
    allowed_v += lift_at(demand, state[TEMPERATURE])
    settled, before_v, lines = _settle(cell, run, current, length_s, allowed_v)
    if not settled or _bends(cell, run, current, lines.start_a, tolerance):
        return False
    run.leak_start_a[run.segment] = lines.start_a
    end[DEPTH] = state[DEPTH] + lines.moved
    after_v, highest_v, heat = _close_pairs(cell, run, current, lines.start_a, length_s)
    slow_v, drift_v = _close(cell, run, current, length_s, ambient_k, lines, heat)
    highest_v += slow_v + abs(drift_v)
    allowed_v += min(0.0, demand.lift_v_k * (end[TEMPERATURE] - state[TEMPERATURE]))
    if (
        highest_v > allowed_v
        or end[TEMPERATURE] > demand.highest_k
        or end[TEMPERATURE] < demand.lowest_k
        or (demand.charging and cell.cells * highest_v * current > demand.power_w)
        or end[DEPTH] < max(limits[0], max(limits[4], limits[STAGE_EDGE]))
        or max(state[TEMPERATURE], end[TEMPERATURE]) > min(limits[3], limits[7])
    ):
        return False
    if cell.acceptance == 1:
        v = run.value[cell.pairs]
        if min(v[0], min(v[1], v[2])) < 0.0:
            return False
    terminal = run.at[TERMINAL_V]
    terminal[START], terminal[2] = before_v + slow_v - drift_v, after_v + slow_v + drift_v
    return True


@inlined
def _settle(cell: Cell, run: Run, current: float, length_s: float, allowed_v: float) -> tuple[bool, float, Lines]:
    """Let side current and pairs settle; return whether they did, the pairs' voltage at the start, the lines."""
    start_k, depth, ratio = run.state[TEMPERATURE], run.state[DEPTH], run.leak[run.segment]
    b0, b1, b2 = length_s * _SHARES[0], length_s * _SHARES[1], length_s * _SHARES[2]
    before_v = 0.0
    for k in range(cell.pairs + cell.acceptance):
        before_v += run.state[RELAXATIONS + k]
    enough_a = _SETTLED * _flow(cell, current)
    settled = False
    start_a, moved = run.leak_start_a[run.segment], 0.0
    open_v = open_slope = entropy = entropy_slope = ohm = ohm_slope = 0.0
    for _ in range(_PASSES):
        moved = (start_a * (b0 * ratio[0] + b1 * ratio[1] + b2 * ratio[2]) - current * length_s) * cell.per_as
        middle, warmer = depth + 0.5 * moved, start_k + 0.5 * ratio[_MEAN] - REFERENCE_K
        open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, middle)
        entropy, entropy_slope = value_and_slope(cell, ENTROPIC, middle)
        ohm, ohm_slope = value_and_slope(cell, SERIES, middle)
        slow_v = open_v + entropy * warmer
        if before_v + slow_v + ohm * current > allowed_v:
            break
        drift_v = 0.5 * (moved * (open_slope + entropy_slope * warmer) + entropy * ratio[_MEAN])
        start = _leak_at_start(cell, before_v + slow_v - drift_v, start_k)
        start_a = start.current_a
        _follow_pairs(cell, run, current, start_a, middle, moved)
        change = _renew_ratios(cell, run, start, before_v, drift_v)
        if start_a * change <= enough_a:
            settled = True
            break
    moved = (start_a * (b0 * ratio[0] + b1 * ratio[1] + b2 * ratio[2]) - current * length_s) * cell.per_as
    return settled, before_v, Lines(start_a, moved, open_v, open_slope, entropy, entropy_slope, ohm, ohm_slope)


@inlined
def _flow(cell: Cell, current: float) -> float:
    """Return the current on whose scale errors are told: at rest, that of a thousandth of the capacity in an hour."""
    return float(abs(current) + 1e-3 / (3600.0 * cell.per_as))


@inlined
def _bends(cell: Cell, run: Run, current: float, start_a: float, tolerance: float) -> bool:
    """Tell whether the side current bends more than a quadratic follows, by the measure of `step_error`."""
    ratio = run.leak[run.segment]
    missed = start_a * (_BACK[0] * ratio[0] + _BACK[1] * ratio[1] + _BACK[2] * ratio[2] - 1.0)
    swing = start_a * max(abs(1.0 - ratio[2]), abs(ratio[0] - ratio[2])) + abs(missed) + 1e-300
    return bool(CURRENT_ERROR * missed * missed >= tolerance * swing * _flow(cell, current))


@inlined
def _close_pairs(
    cell: Cell, run: Run, current: float, start_a: float, length_s: float
) -> tuple[float, float, PairSums]:
    """Write the pairs' ends and heat; return their voltage at the end, the highest it can be, and their sums."""
    state, end, gain, ratio = run.state, run.end, run.gain, run.leak[run.segment]
    q0, q1, q2 = (
        length_s * start_a * _SHARES[0] * ratio[0],
        length_s * start_a * _SHARES[1] * ratio[1],
        length_s * start_a * _SHARES[2] * ratio[2],
    )
    after_v = highest_v = passed_v = heat_j = leaked_j = 0.0
    for k in range(cell.pairs + cell.acceptance):
        before, v = state[RELAXATIONS + k], run.value[k]
        after = v[2]
        leaked = q0 * v[0] + q1 * v[1] + q2 * after
        heat = current * v[_MEAN] * length_s - leaked
        resistance, half_ohm = run.resistance[k, 0], run.resistance[k, 1]
        if resistance > 0.0:
            stored = after * after / (resistance + half_ohm) - before * before / (resistance - half_ohm)
            heat -= 0.5 * cell.tau_s[k] * stored
        end[RELAXATIONS + k], gain[PAIR_HEAT + k] = after, cell.cells * heat
        after_v, passed_v, highest_v = after_v + after, passed_v + v[_MEAN], highest_v + max(before, after)
        heat_j, leaked_j = heat_j + heat, leaked_j + leaked
    later_as = q0 * (2.0 * _FIRST - 1.0) + q1 * (2.0 * _SECOND - 1.0) + q2
    return after_v, highest_v, PairSums(passed_v, heat_j, leaked_j, q0 + q1 + q2, later_as)


@inlined
def _close(
    cell: Cell, run: Run, current: float, length_s: float, ambient_k: float, lines: Lines, pairs: PairSums
) -> tuple[float, float]:
    """Write temperature and gains; return the voltage beside the pairs in the middle, and what it drifts until the end.

    The battery's heat is taken at the temperature of the start, then at that of the middle.
    """
    gain, start_k, side_as = run.gain, run.state[TEMPERATURE], pairs.side_as
    # Reciprocals, for what is divided waits for nothing else.
    loss, per_j = 1.0 / cell.thermal_resistance_k_w, 1.0 / cell.heat_capacity_j_k
    main_as = current * length_s - side_as
    series_j, reversible_jk = lines.ohm * current * current * length_s, main_as * lines.entropy
    warmer, still_j = start_k - REFERENCE_K, series_j + pairs.heat_j + pairs.leaked_j
    heat_j = cell.cells * (still_j + side_as * (lines.open_v + lines.entropy * warmer) + reversible_jk * start_k)
    half_k = 0.5 * (heat_j - (start_k - ambient_k) * loss * length_s) * per_j
    slow_v = lines.open_v + lines.entropy * (warmer + half_k)
    drift_v = 0.5 * lines.moved * (lines.open_slope + lines.entropy_slope * warmer) + lines.entropy * half_k
    side_j = pairs.leaked_j + side_as * slow_v + pairs.later_as * drift_v
    reversible_j, ambient_j = reversible_jk * (start_k + half_k), (start_k + half_k - ambient_k) * loss * length_s
    heat_j = cell.cells * (series_j + pairs.heat_j + side_j + reversible_j)
    rise_k = (heat_j - ambient_j) * per_j
    run.end[TEMPERATURE], run.leak[run.segment, _MEAN] = start_k + rise_k, rise_k
    slow_v += lines.ohm * current
    drift_v += 0.5 * lines.moved * lines.ohm_slope * current
    gain[CHARGE], gain[SIDE_CHARGE], gain[TO_AMBIENT] = current * length_s, side_as, ambient_j
    gain[VOLTAGE_TIME] = cell.cells * (slow_v + pairs.passed_v) * length_s
    gain[ELECTRICAL] = gain[VOLTAGE_TIME] * current
    gain[SERIES_HEAT], gain[SIDE_HEAT] = cell.cells * series_j, cell.cells * side_j
    gain[REVERSIBLE_HEAT] = cell.cells * reversible_j
    return slow_v, drift_v


@inlined
def _follow_pairs(cell: Cell, run: Run, current: float, start_a: float, middle: float, moved: float) -> None:
    """Write the pairs' voltages for the side current guessed; resistances in the middle and their half change."""
    weights, ratio = run.leak_weights[run.segment], run.leak[run.segment]
    i0, i1, i2 = start_a * ratio[0], start_a * ratio[1], start_a * ratio[2]
    for k in range(cell.pairs + cell.acceptance):
        if k == cell.pairs:
            reciprocal = 1.0 / middle
            resistance = cell.acceptance_ohm * reciprocal
            slope = -resistance * reciprocal
        else:
            resistance, slope = value_and_slope(cell, FIRST_PAIR + k, middle)
        half_ohm = 0.5 * slope * moved
        run.resistance[k, 0], run.resistance[k, 1] = resistance, half_ohm
        first, rise, w = (resistance - half_ohm) * current, 2.0 * half_ohm * current, weights[k]
        g0, g1, g2, v = resistance * i0, resistance * i1, resistance * i2, run.state[RELAXATIONS + k]
        s, c, r, d, e, f = w[_OF_START], w[_OF_STEP], w[_OF_RAMP], w[_OF_SIDE], w[_OF_SIDE + 1], w[_OF_SIDE + 2]
        v0 = s[0] * v + c[0] * first + r[0] * rise - (d[0] * g0 + e[0] * g1 + f[0] * g2)
        v1 = s[1] * v + c[1] * first + r[1] * rise - (d[1] * g0 + e[1] * g1 + f[1] * g2)
        v2 = s[2] * v + c[2] * first + r[2] * rise - (d[2] * g0 + e[2] * g1 + f[2] * g2)
        v3 = s[3] * v + c[3] * first + r[3] * rise - (d[3] * g0 + e[3] * g1 + f[3] * g2)
        put(run.value[k], v0, v1, v2, v3)


@inlined
def _leak_at_start(cell: Cell, voltage_v: float, start_k: float) -> Leak:
    """Return the side current at the start of a segment, infinite where it is out of all bounds, and its slopes."""
    per_v = 1.0 / (cell.side_scale_v + cell.side_scale_v_per_k * start_k)
    excess = (voltage_v - cell.side_reference_v) * per_v
    activation = cell.side_arrhenius_k / (start_k * cell.side_reference_k)
    exponent = excess + (start_k - cell.side_reference_k) * (cell.side_linear_per_k + activation)
    warmth = cell.side_linear_per_k + activation * cell.side_reference_k / start_k
    current_a = cell.side_a * math.exp(exponent) if exponent < _HIGHEST_EXPONENT else math.inf
    return Leak(current_a, per_v, warmth - excess * per_v * cell.side_scale_v_per_k)


@inlined
def _renew_ratios(cell: Cell, run: Run, start: Leak, before_v: float, drift_v: float) -> float:
    """Replace the side currents at the nodes, by that at the start, by those of the voltages there.

    Returns
    -------
    The largest change [1], infinite where the voltages are too far from the start's for the series.
    """
    ratio = run.leak[run.segment]
    warming, double_v = ratio[_MEAN] * start.per_k, 2.0 * drift_v
    v0 = v1 = v2 = 0.0
    for k in range(cell.pairs + cell.acceptance):
        v = run.value[k]
        v0, v1, v2 = v0 + v[0], v1 + v[1], v2 + v[2]
    e0 = (v0 - before_v + _FIRST * double_v) * start.per_v + _FIRST * warming
    e1 = (v1 - before_v + _SECOND * double_v) * start.per_v + _SECOND * warming
    e2 = (v2 - before_v + double_v) * start.per_v + warming
    if not max(abs(e0), max(abs(e1), abs(e2))) < SERIES_BELOW:
        return math.inf
    a0, a1, a2, rise = growth(e0), growth(e1), growth(e2), ratio[_MEAN]
    change = max(abs(a0 - ratio[0]), max(abs(a1 - ratio[1]), abs(a2 - ratio[2])))
    put(ratio, a0, a1, a2, rise)
    return float(change)


@kernel
def _weigh(cell: Cell, run: Run, length_s: float) -> None:
    """Write how the pairs follow over a segment, and forget the side current of another length."""
    run.plain_s[run.segment] = length_s
    put(run.leak[run.segment], 1.0, 1.0, 1.0, 0.0)
    run.leak_start_a[run.segment] = 0.0
    phi, row = run.phi, run.row
    for k in range(cell.pairs + cell.acceptance):
        z, w = length_s / cell.tau_s[k], run.leak_weights[run.segment, k]
        for j in range(3):
            theta = NODES[j]
            w[_OF_START, j] = response(z, theta, phi, row)
            w[_OF_STEP, j], w[_OF_RAMP, j] = z * theta * phi[1], z * theta * theta * phi[2]
            for node in range(3):
                w[_OF_SIDE + node, j] = row[node]
        phi_functions(-z, 4, phi)
        w[_OF_START, _MEAN], w[_OF_STEP, _MEAN], w[_OF_RAMP, _MEAN] = phi[1], z * phi[2], z * phi[3]
        for node in range(3):
            a, b, c = LAGRANGE[0, node] * phi[2], LAGRANGE[1, node] * phi[3], 2.0 * LAGRANGE[2, node] * phi[4]
            w[_OF_SIDE + node, _MEAN] = z * (a + b + c)


@inlined
def cross_leaking(
    cell: Cell,
    run: Run,
    book: Book,
    demand: Demand,
    limits: NDArray[np.float64],
    ambient_k: float,
    length_s: float,
    tolerance: float,
) -> bool:
    """Cross the segment that the run is at; False, and nothing done, where something may happen in it.

    The cell must be leaking, and nothing that has its time may fall due in the segment.
    """
    if not leak_across(cell, run, demand, limits, ambient_k, length_s, tolerance):
        return False
    if passes_mark(book, run.end[DEPTH]):
        return False
    terminal = run.at[TERMINAL_V]
    add_plain(cell, run, book, demand.current_a, length_s, terminal[START], terminal[2])
    for part in range(RELAXATIONS + cell.pairs + cell.acceptance):
        run.state[part] = run.end[part]
    return True
