"""The `averaged` driver: strides over many periods, each made of a few periods that are really run.

Which period to run next is decided here; running it is the driver's, by the same function as every other. Between
strides, where one would be short, near stops and in windows, periods run one by one. Below `AVERAGED_ABOVE_HZ` they do
so at samples and marks of SOC too; above it a sample inside a period stands on the line between the periods' starts.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.charge.dense import serve
from pipeline.charge.measured import keep_period, learn, measure, meets_stop, predict, stride_error
from pipeline.charge.period import Clock
from pipeline.charge.program import AVERAGED_ABOVE_HZ, Program
from pipeline.charge.record_keeping import Book, passes_mark, reset_extremes
from pipeline.charge.segment import NOTHING
from pipeline.charge.state import DEPTH, RELAXATIONS, Run
from pipeline.charge.stride import END, FIRST, TRIED, Stride, copy, correct, keep_slope, move, nudge, weigh
from pipeline.jit import inlined

# What a stride is at: nothing, its first period, those at its nodes, those that tell slopes.
_IDLE, _AT_START, _AT_NODES, _AT_SLOPES = range(4)
# What to do next.
_RUN, _ATTEMPT, _CORRECT, _TELL_SLOPES, _FINISH, _SHORTEN, _REFUSE = range(7)
# Periods of the shortest stride: it runs about nine.
_FEWEST = 16
_SETTLING = 4
_ITERATIONS = 12
# Mismatch of the forcings, in units of their scales and of the tolerance, at which an iteration ends.
_CLOSED = 1e-1
# An iteration that leaves more than this of its mismatch gets new slopes.
_SLOW = 0.2
_MUCH_SHORTER = 0.3
# SOC that a stride moves at most: the start says nothing of what waits at the next knot of a table.
_MOST_MOVED = 0.01
LONGEST = 2.0
"""Longest stride, in units of the longest step allowed."""


@inlined
def begin_strides(stride: Stride) -> None:
    """Forget what was found in another course."""
    stride.proposal, stride.last, stride.sloped, stride.phase = 0.0, 0, 0, _IDLE


@inlined
def next_periods(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    run: Run,
    book: Book,
    clock: Clock,
    stride: Stride,
    own: Clock,
    scratch: Book,
    course: int,
    ended: int,
    tolerance: float,
    maximum_step_s: float,
) -> int:
    """Return how many periods to run one by one; 0 is one period of a stride, with its own clock and scratch book.

    Arguments
    ---------
    ended : what ended the stride's period that was run last, if one was.
    """
    todo = _RUN
    if stride.phase != _IDLE:
        todo = _take_in(cell, run, stride, scratch, clock.period_s, ended, tolerance)
        while todo != _RUN and todo != _REFUSE:
            if todo == _FINISH:
                todo = _finish(cell, program, stride, course, tolerance)
                if todo == _RUN and _is_slow(clock) and passes_mark(book, _deepest(stride)):
                    todo = _SHORTEN
                if todo == _RUN:
                    _accept(cell, program, run, book, clock, stride, course)
            elif todo == _SHORTEN:
                stride.count = int(stride.count * min(stride.factor, 0.8))
                todo = _ATTEMPT if stride.count >= _FEWEST else _REFUSE
            elif todo == _TELL_SLOPES:
                stride.phase, stride.part, stride.at = _AT_SLOPES, 0, TRIED
                nudge(stride, 0)
                todo = _RUN
            else:
                if todo == _ATTEMPT:
                    weigh(stride, stride.count)
                    predict(stride)
                    stride.iteration, stride.fresh, stride.mismatch = 0, 0, math.inf
                    stride.tried += 1
                else:
                    correct(stride)
                    stride.iteration += 1
                stride.factor = _MUCH_SHORTER
                todo = _RUN if stride.iteration < _ITERATIONS and _place_nodes(stride) else _SHORTEN
        if todo == _REFUSE:
            _restore(run, stride)
            stride.proposal, stride.last = _FEWEST, 0
            return _FEWEST
    if stride.phase == _IDLE:
        alone = _begin(cell, program, supply_time_s, run, book, clock, stride, own, maximum_step_s)
        if alone > 0:
            return alone
    copy(run.state, stride.place[stride.at])
    scratch.sums[:] = 0.0
    scratch.recent_gains[:] = 0.0
    scratch.peak_k[0] = 0.0
    reset_extremes(scratch)
    own.time_s, own.periods, stride.changes_before = 0.0, 0, run.changes
    return 0


@inlined
def _is_slow(clock: Clock) -> bool:
    """Tell whether a period is so long that what happens inside it is looked at: samples and marks, beside stops."""
    return bool(clock.period_s * AVERAGED_ABOVE_HZ >= 1.0)


@inlined
def _deepest(stride: Stride) -> float:
    """Return the least 1 - SOC that is reached near the end of a stride, in its last period or the next."""
    return float(stride.place[END, DEPTH] - stride.scale[DEPTH])


@inlined
def _begin(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    run: Run,
    book: Book,
    clock: Clock,
    stride: Stride,
    own: Clock,
    maximum_step_s: float,
) -> int:
    """Prepare the first period of a stride; return how many periods to run one by one where there is none."""
    if stride.proposal == 0.0:
        stride.proposal = _FEWEST
        return _SETTLING
    room, seen = _room(program, supply_time_s, book, clock)
    if room < _FEWEST:
        stride.proposal, stride.last = _FEWEST, 0
        return max(seen, room + 3, 1)
    longest = max(float(_FEWEST), LONGEST * maximum_step_s / clock.period_s)
    stride.count = int(min(float(room), longest, stride.proposal))
    own.period_s, own.supply, own.next_sample = clock.period_s, clock.supply, 1
    own.sample_interval_s = own.phase_end_s = math.inf
    own.course_start_s = 0.0
    stride.edges_before, stride.all_changes = run.edges, run.changes
    stride.phase, stride.at = _AT_START, FIRST
    stride.parts = RELAXATIONS + cell.relaxations
    copy(stride.before, run.state)
    copy(stride.place[FIRST], run.state)
    return 0


@inlined
def _room(program: Program, supply_time_s: NDArray[np.float64], book: Book, clock: Clock) -> tuple[int, int]:
    """Return how many whole periods are free of everything that has its time, and how many are in a window."""
    time_s, period_s = clock.time_s, clock.period_s
    until_s = min(clock.phase_end_s, program.stop_elapsed_s)
    if clock.supply + 1 < len(supply_time_s):
        until_s = min(until_s, supply_time_s[clock.supply + 1])
    if _is_slow(clock):
        until_s = min(until_s, clock.next_sample * clock.sample_interval_s)
    for window in range(len(book.windows)):
        if book.windows[window, 1] > time_s:
            if book.windows[window, 0] <= time_s + 2.0 * period_s:
                return 0, math.ceil((book.windows[window, 1] - time_s) / period_s) + 1
            until_s = min(until_s, book.windows[window, 0])
    # One period is left out, for those at the nodes begin half a period late.
    return int(min((until_s - time_s) / period_s, 1e15)) - 1, 0


@inlined
def _take_in(cell: Cell, run: Run, stride: Stride, scratch: Book, period_s: float, ended: int, tolerance: float) -> int:
    """Take in the period just run; return what to do next."""
    if ended != NOTHING:
        stride.factor = _MUCH_SHORTER
        return _REFUSE if stride.phase == _AT_START else _SHORTEN
    keep_period(run, scratch, stride)
    if stride.phase == _AT_START:
        learn(cell, run, stride, period_s)
        stride.count = max(_FEWEST, min(stride.count, int(_MOST_MOVED / stride.scale[DEPTH])))
        return _ATTEMPT
    measure(cell, run, stride)
    if stride.phase == _AT_NODES:
        stride.at += 1
        return _RUN if stride.at < FIRST else _judge(stride, tolerance)
    keep_slope(stride, stride.part)
    stride.part += 1
    if stride.part < stride.parts:
        nudge(stride, stride.part)
        return _RUN
    stride.sloped, stride.fresh, stride.eliminated = 1, 1, 0
    return _CORRECT


@inlined
def _place_nodes(stride: Stride) -> bool:
    """Place the nodes where the forcings lead; False where more is charged than there is room for."""
    stride.phase, stride.at = _AT_NODES, 0
    for j in range(3):
        move(stride, j)
    place = stride.place
    return bool(min(place[0, DEPTH], min(place[1, DEPTH], place[2, DEPTH])) > 0.0)


@inlined
def _judge(stride: Stride, tolerance: float) -> int:
    """Compare what the nodes measured with the forcings that led to them."""
    before, mismatch = stride.mismatch, 0.0
    for j in range(3):
        for k in range(stride.parts):
            gap = abs(stride.measured[j, k] - stride.forcing[j, k]) / stride.scale[k]
            mismatch = gap if not gap <= mismatch else mismatch
    stride.mismatch, stride.factor = mismatch, _MUCH_SHORTER
    if not math.isfinite(mismatch):
        return _SHORTEN
    if mismatch <= _CLOSED * tolerance:
        return _FINISH
    if mismatch > _SLOW * before:
        if stride.fresh == 0:
            return _TELL_SLOPES
        if mismatch > before and stride.iteration > 2:
            return _SHORTEN
    return _CORRECT


@inlined
def _finish(cell: Cell, program: Program, stride: Stride, course: int, tolerance: float) -> int:
    """Take what was measured for the forcings; return `_RUN` where the stride is good."""
    for j in range(3):
        for k in range(stride.parts):
            stride.forcing[j, k] = stride.measured[j, k]
    move(stride, END)
    stride.factor = _MUCH_SHORTER
    if not stride.place[END, DEPTH] > 0.0 or meets_stop(program, stride, course):
        return _SHORTEN
    error = stride_error(cell, stride) / tolerance
    stride.factor = min(4.0, max(0.2, 0.9 * error ** (-1.0 / 3.0))) if error > 0.0 else 4.0
    return _RUN if error < 1.0 else _SHORTEN


@inlined
def _restore(run: Run, stride: Stride) -> None:
    """Leave the run as it was before the stride."""
    run.edges, run.changes = stride.edges_before, stride.all_changes
    copy(run.state, stride.before)
    stride.phase = _IDLE


@inlined
def _accept(cell: Cell, program: Program, run: Run, book: Book, clock: Clock, stride: Stride, course: int) -> None:
    """Make the end of the stride the state of the run, and write what fell due in it."""
    count = stride.count
    _restore(run, stride)
    serve(cell, run, book, clock, stride, count)
    for j in range(3):
        copy(stride.past[j], stride.forcing[j])
    stride.proposal = max(count * stride.factor, float(_FEWEST))
    stride.last = count
    stride.taken += 1
    run.edges += count * program.segments[course]
