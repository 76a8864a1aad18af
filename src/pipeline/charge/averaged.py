"""The `averaged` driver: strides over many periods, each made of a few periods that are really run.

Between strides, where a stride would be short, near stops and in windows, periods run one by one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import NODES
from pipeline.charge.coupling import correct, keep_slope, nudge
from pipeline.charge.dense import serve
from pipeline.charge.period import Clock, run_periods
from pipeline.charge.program import Program
from pipeline.charge.record_keeping import CHARGE_IN, CHARGE_OUT, ENERGY_IN, ENERGY_OUT, Book, reset_extremes
from pipeline.charge.segment import NOTHING
from pipeline.charge.state import (
    DEPTH,
    ELECTRICAL,
    HYSTERESIS,
    HYSTERESIS_HEAT,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE_HEAT,
    TEMPERATURE,
    TO_AMBIENT,
    TRANSFER_HEAT,
    Run,
)
from pipeline.charge.stride import (
    CHANGES,
    END,
    FIRST,
    GAINS_FROM,
    PEAK_K,
    TRIED,
    Stride,
    at_node_fraction,
    copy,
    highest,
    keep_ratios,
    move,
    weigh,
)
from pipeline.jit import inlined, kernel

# Periods of the shortest stride: it runs about nine.
_FEWEST = 16
_SETTLING = 4
_ITERATIONS = 12
# Mismatch of the forcings, in units of their scales and of the tolerance, at which an iteration ends.
_CLOSED = 1e-2
# An iteration that leaves more than this of its mismatch gets new slopes.
_SLOW = 0.2
# What the quadratics miss at the start of a stride, where it is known, weighs this much.
_SHARE = 1e-2


@inlined
def begin_strides(stride: Stride) -> None:
    """Forget what was found in another course."""
    stride.proposal, stride.last, stride.sloped = 0.0, 0, 0


@kernel
def stride_on(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    run: Run,
    book: Book,
    clock: Clock,
    stride: Stride,
    own: Clock,
    scratch: Book,
    course: int,
    ambient_k: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
) -> int:
    """Stride on as far as strides go; return how many periods to run one by one then."""
    if stride.proposal == 0.0:
        stride.proposal = _FEWEST
        return _SETTLING
    period_s = clock.period_s
    while True:
        room, busy = _room(program, supply_time_s, book, clock)
        if busy > 0:
            stride.last = 0
            return busy
        if room < _FEWEST:
            stride.last = 0
            stride.proposal = _FEWEST
            return max(room, 0) + 3
        longest = max(float(_FEWEST), maximum_step_s / period_s)
        count = int(min(float(room), longest, stride.proposal))
        own.period_s, own.supply, own.group = period_s, clock.supply, clock.group
        own.sample_interval_s = own.phase_end_s = math.inf
        own.course_start_s, own.next_sample = 0.0, 1
        edges, changes = run.edges, run.changes
        copy(stride.before, run.state)
        taken = 0
        copy(stride.place[FIRST], run.state)
        stride.ratio[HYSTERESIS] = 0.0
        stride.parts = RELAXATIONS + cell.relaxations
        # fmt: off
        if run_one(cell, program, supply_time_s, supply_power_w, run, stride, own, scratch, course, FIRST, ambient_k,
                   tolerance, maximum_step_s, maximum_steps):
            added = stride.added[FIRST]
            moved = (added[CHARGE_IN] + added[CHARGE_OUT]) * cell.per_as
            keep_ratios(cell, stride, period_s, moved)
            measure(cell, run, stride, FIRST)
            set_scales(cell, stride, period_s)
            while count >= _FEWEST:
                weigh(cell, stride, count, period_s)
                predict(stride, count)
                stride.tried += 1
                factor = 0.3
                if solve(cell, program, supply_time_s, supply_power_w, run, stride, own, scratch, course, ambient_k,
                         tolerance, maximum_step_s, maximum_steps) and not _meets(program, stride, course):
                    error = stride_error(cell, stride, count) / tolerance
                    factor = min(4.0, max(0.2, 0.9 * error ** (-1.0 / 3.0))) if error > 0.0 else 4.0
                    if error < 1.0:
                        taken = count
                        stride.proposal = max(count * factor, float(_FEWEST))
                        break
                count = int(count * min(factor, 0.8))
        # fmt: on
        run.edges, run.changes = edges, changes
        copy(run.state, stride.before)
        if taken == 0:
            stride.proposal, stride.last = _FEWEST, 0
            return _FEWEST
        serve(cell, run, book, clock, stride, taken)
        for j in range(3):
            copy(stride.past[j], stride.forcing[j])
        stride.last = taken
        stride.taken += 1
        run.edges += taken * program.segments[course]


@inlined
def _room(program: Program, supply_time_s: NDArray[np.float64], book: Book, clock: Clock) -> tuple[int, int]:
    """Return how many whole periods are free of everything that has its time, and how many are in a window."""
    time_s, period_s = clock.time_s, clock.period_s
    until_s = min(clock.phase_end_s, program.stop_elapsed_s)
    if clock.supply + 1 < len(supply_time_s):
        until_s = min(until_s, supply_time_s[clock.supply + 1])
    for window in range(len(book.windows)):
        if book.windows[window, 1] > time_s:
            if book.windows[window, 0] <= time_s + 2.0 * period_s:
                return 0, math.ceil((book.windows[window, 1] - time_s) / period_s) + 1
            until_s = min(until_s, book.windows[window, 0])
    # One period is left out, for those at the nodes begin half a period late.
    return int(min((until_s - time_s) / period_s, 1e15)) - 1, 0


@kernel
def run_one(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    run: Run,
    stride: Stride,
    own: Clock,
    scratch: Book,
    course: int,
    row: int,
    ambient_k: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
) -> bool:
    """Run a period from the state in a row of places and keep what it added; False where anything ends the course."""
    copy(run.state, stride.place[row])
    scratch.sums[:] = 0.0
    scratch.recent_gains[:] = 0.0
    scratch.peak_k[0] = 0.0
    reset_extremes(scratch)
    own.time_s, own.periods = 0.0, 0
    changes = run.changes
    reason = run_periods(
        cell,
        program,
        supply_time_s,
        supply_power_w,
        run,
        scratch,
        own,
        course,
        1,
        ambient_k,
        tolerance,
        maximum_step_s,
        maximum_steps,
    )
    added, seen = stride.added[row], stride.seen[row]
    copy(added, scratch.sums)
    copy(added[GAINS_FROM:], scratch.recent_gains)
    added[CHANGES] = run.changes - changes
    copy(seen, scratch.extremes)
    seen[PEAK_K] = scratch.peak_k[0]
    return bool(reason == NOTHING)


@inlined
def measure(cell: Cell, run: Run, stride: Stride, row: int) -> None:
    """Write what the period just run added to each part of the state."""
    place, measured = stride.place[row], stride.measured[row]
    for k in range(stride.parts):
        measured[k] = run.state[k] - math.exp(-stride.ratio[k]) * place[k]
    # From the sums themselves, not from the small difference of two temperatures.
    gains = stride.added[row, GAINS_FROM:]
    measured[TEMPERATURE] = (_heat_of(cell, gains, False) - gains[TO_AMBIENT]) / cell.heat_capacity_j_k


@inlined
def _heat_of(cell: Cell, gains: NDArray[np.float64], magnitudes: bool) -> float:
    heat = 0.0
    for path in (SERIES_HEAT, TRANSFER_HEAT, REVERSIBLE_HEAT, SIDE_HEAT, HYSTERESIS_HEAT):
        heat += abs(gains[path]) if magnitudes else gains[path]
    for k in range(cell.pairs + cell.acceptance):
        heat += gains[PAIR_HEAT + k]
    return float(heat)


@inlined
def set_scales(cell: Cell, stride: Stride, period_s: float) -> None:
    """Write the scale of what a period adds to each part of the state, and by how much to nudge each for slopes."""
    added, scale, step = stride.added[FIRST], stride.scale, stride.nudge
    gains = added[GAINS_FROM:]
    moved_as = added[CHARGE_IN] + added[CHARGE_OUT] + 1e-12 * cell.charge_as
    ohmic_v = gains[SERIES_HEAT] / (cell.cells * moved_as) + 1e-4
    scale[DEPTH] = moved_as * cell.per_as
    scale[TEMPERATURE] = (_heat_of(cell, gains, True) + 1e-6 * moved_as) / cell.heat_capacity_j_k
    scale[HYSTERESIS] = -math.expm1(-stride.ratio[HYSTERESIS]) * ohmic_v + 1e-300
    step[DEPTH], step[TEMPERATURE], step[HYSTERESIS] = min(1e-4, 1e-3 * stride.before[DEPTH]), 1e-2, 1e-2 * ohmic_v
    for k in range(cell.relaxations):
        unit = ohmic_v if k < cell.pairs + cell.acceptance else moved_as / period_s
        scale[RELAXATIONS + k] = -math.expm1(-stride.ratio[RELAXATIONS + k]) * unit
        step[RELAXATIONS + k] = 1e-2 * unit


@inlined
def predict(stride: Stride, count: int) -> None:
    """Guess the forcings: those of the last stride extrapolated, through what the first period measured."""
    past, last = stride.past, float(stride.last)
    for k in range(stride.parts):
        a, b, c, first = past[0, k], past[1, k], past[2, k], stride.measured[FIRST, k]
        stride.forcing[:, k] = first
        if last > 0.0 and count <= 2.0 * last:
            known = at_node_fraction(a, b, c, 1.0 + 0.5 / last)
            for j in range(3):
                theta = 1.0 + NODES[j] * count / last
                stride.forcing[j, k] = first + at_node_fraction(a, b, c, theta) - known


@kernel
def solve(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    run: Run,
    stride: Stride,
    own: Clock,
    scratch: Book,
    course: int,
    ambient_k: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
) -> bool:
    """Find the forcings that the periods at the nodes, begun where these lead, really measure; True when found."""
    before, fresh = math.inf, False
    # fmt: off
    for iteration in range(_ITERATIONS):
        mismatch = 0.0
        for j in range(3):
            move(stride, j)
            if not stride.place[j, DEPTH] > 0.0:
                return False
            if not run_one(cell, program, supply_time_s, supply_power_w, run, stride, own, scratch, course, j,
                           ambient_k, tolerance, maximum_step_s, maximum_steps):
                return False
            measure(cell, run, stride, j)
            for k in range(stride.parts):
                mismatch = max(mismatch, abs(stride.measured[j, k] - stride.forcing[j, k]) / stride.scale[k])
        if not math.isfinite(mismatch):
            return False
        if mismatch <= _CLOSED * tolerance:
            for j in range(3):
                for k in range(stride.parts):
                    stride.forcing[j, k] = stride.measured[j, k]
            move(stride, END)
            return bool(stride.place[END, DEPTH] > 0.0)
        if mismatch > _SLOW * before:
            if fresh and mismatch > before and iteration > 2:
                return False
            if not fresh:
                for k in range(stride.parts):
                    nudge(stride, k)
                    if not run_one(cell, program, supply_time_s, supply_power_w, run, stride, own, scratch, course,
                                   TRIED, ambient_k, tolerance, maximum_step_s, maximum_steps):
                        return False
                    measure(cell, run, stride, TRIED)
                    keep_slope(stride, k)
                stride.sloped, fresh = 1, True
        before = mismatch
        correct(stride)
    # fmt: on
    return False


@inlined
def _meets(program: Program, stride: Stride, course: int) -> bool:
    """Tell whether a voltage or temperature that stops the charge may lie between the nodes."""
    limits, seen = program.limits[course], stride.seen
    volt = highest(seen[0, 1], seen[1, 1], seen[2, 1])
    warm = highest(seen[0, PEAK_K], seen[1, PEAK_K], seen[2, PEAK_K])
    return bool(volt >= min(limits[1], limits[5]) or warm >= min(limits[3], limits[7]))


@inlined
def stride_error(cell: Cell, stride: Stride, count: int) -> float:
    """Return the error of a stride in units of its own sums, per unit of tolerance 1.

    The quadratics through what the nodes add, extrapolated to the start, against the period run there.
    """
    added = stride.added
    first = added[FIRST]
    moved_as = first[CHARGE_IN] + first[CHARGE_OUT] + 1e-12 * cell.charge_as
    energy_j = first[ENERGY_IN] + first[ENERGY_OUT] + 1e-12 * cell.charge_as
    charge = _miss(added[:, CHARGE_IN], count) - _miss(added[:, CHARGE_OUT], count)
    electrical = _miss(added[:, GAINS_FROM + ELECTRICAL], count)
    depth = _miss(stride.measured[:, DEPTH], count) / stride.scale[DEPTH]
    warmth = _miss(stride.measured[:, TEMPERATURE], count) / stride.scale[TEMPERATURE]
    return float(_SHARE * max(max(abs(charge) / moved_as, abs(electrical) / energy_j), max(abs(depth), abs(warmth))))


@inlined
def _miss(values: NDArray[np.float64], count: int) -> float:
    return float(at_node_fraction(values[0], values[1], values[2], 0.5 / count) - values[FIRST])
