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
from pipeline.charge.record_keeping import SUPPLY_LIMITED_S, VOLTAGE_LIMITED_S, Book, passes_mark, reset_extremes
from pipeline.charge.segment import NOTHING
from pipeline.charge.state import DEPTH, RELAXATIONS, Run
from pipeline.charge.stride import (
    CHANGES,
    END,
    FIRST,
    TRIED,
    Stride,
    copy,
    correct,
    improve_slopes,
    keep_slope,
    move,
    nudge,
    weigh,
)
from pipeline.jit import inlined

# What a stride is at: nothing, its first period, those at its nodes, those that tell slopes.
_IDLE, _AT_START, _AT_NODES, _AT_SLOPES = range(4)
# What to do next.
_RUN, _ATTEMPT, _CORRECT, _TELL_SLOPES, _FINISH, _SHORTEN, _REFUSE = range(7)
# Periods of the shortest stride: it runs four to ten.
_FEWEST = 16
# Most of those that run one by one until another is tried.
_MOST_ALONE = 8 * _FEWEST
_SETTLING = 4
_ITERATIONS = 12
# Mismatch of the forcings, in units of their scales and of the tolerance, at which an iteration ends.
_CLOSED = 1e-1
# An iteration that leaves more than this of its mismatch gets new slopes.
_SLOW = 0.2
# One that leaves more than this of it tells how the slopes have changed, unless it was nearly rounding already.
_IMPROVED, _ROUNDED = 0.02, 1e-6
# Mismatch of another iteration, in units of the tolerance, below which it is left out; what an iteration is thought to
# leave at least; strides in a row that may go by the rate of one before them.
_EXPECTED, _LEAST_RATE, _MOST_TRUSTED = 0.2, 1e-4, 5
_MUCH_SHORTER = 0.3
# Error above which a stride is given up before its iterations end, and by how much these may still change it, per unit
# of their mismatch over the tolerance.
_HOPELESS, _STILL_OPEN = 2.0, 0.3
# SOC that a stride moves at most: the start says nothing of what waits at the next knot of a table.
_MOST_MOVED = 0.01
LONGEST = 2.0
"""Longest stride, in units of the longest step allowed."""


@inlined
def begin_strides(stride: Stride) -> None:
    """Forget what was found in another course."""
    stride.proposal, stride.last, stride.sloped, stride.phase = 0.0, 0, 0, _IDLE
    stride.rate, stride.refused, stride.slope[:] = math.inf, 0.0, 0.0


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
                stride.count, stride.shortened = int(stride.count * min(stride.factor, 0.8)), 1
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
            return _until_smooth(stride)
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
def _until_smooth(stride: Stride) -> int:
    """Return how many periods to run one by one after a stride was refused.

    What settles does so exponentially: its error falls below what is allowed as it fell since the last refusal.
    """
    error, before, alone = stride.error, stride.refused, _FEWEST
    if 1.0 < error < before:
        alone = int(min(max(stride.alone * math.log(error) / math.log(before / error), _FEWEST), _MOST_ALONE)) + 1
    stride.refused, stride.alone = error, alone
    return alone


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
    stride.phase, stride.at, stride.error, stride.shortened = _AT_START, FIRST, 0.0, 0
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
        return _RUN if stride.at < FIRST else _judge(cell, stride, tolerance)
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
def _judge(cell: Cell, stride: Stride, tolerance: float) -> int:
    """Compare what the nodes measured with the forcings that led to them."""
    before, mismatch = stride.mismatch, 0.0
    for j in range(3):
        for k in range(stride.parts):
            gap = abs(stride.measured[j, k] - stride.forcing[j, k]) / stride.scale[k]
            mismatch = gap if not gap <= mismatch else mismatch
    stride.mismatch, stride.factor = mismatch, _MUCH_SHORTER
    if not math.isfinite(mismatch):
        return _SHORTEN
    if stride.iteration > 0:
        stride.rate, stride.rate_count, stride.trusted = max(mismatch / before, _LEAST_RATE), stride.count, 0
    if mismatch <= _CLOSED * tolerance or _will_close(stride, tolerance):
        return _FINISH
    if _is_hopeless(cell, stride, tolerance):
        return _SHORTEN
    if stride.iteration > 0 and mismatch > _IMPROVED * before:
        if mismatch > _SLOW * before:
            if stride.fresh == 0:
                return _TELL_SLOPES
            if mismatch > before and stride.iteration > 2:
                return _SHORTEN
        if before > _ROUNDED:
            improve_slopes(stride)
    return _CORRECT


@inlined
def _is_hopeless(cell: Cell, stride: Stride, tolerance: float) -> bool:
    """Tell whether the error of a stride is too large whatever its iterations still change."""
    if stride.iteration == 0:
        return False
    _estimate(cell, stride, tolerance)
    if stride.error > _HOPELESS + _STILL_OPEN * stride.mismatch / tolerance:
        return True
    stride.factor = _MUCH_SHORTER
    return False


@inlined
def _estimate(cell: Cell, stride: Stride, tolerance: float) -> None:
    """Write the error of a stride, in units of what is allowed, and by what factor the next may be longer."""
    error = stride_error(cell, stride) / tolerance
    stride.error = error
    stride.factor = min(4.0, max(0.2, 0.9 * error ** (-1.0 / 3.0))) if error > 0.0 else 4.0


@inlined
def _will_close(stride: Stride, tolerance: float) -> bool:
    """Tell whether another iteration would find what the last one did: what it left of the mismatch, once more.

    Without slopes only, for then what was measured is what the iteration leads to. By the rate of an earlier stride
    only where nothing but the sheet's current limits the charge: what a limit does to the rate is sudden.
    """
    expected = stride.rate * stride.mismatch
    if stride.iteration == 0:
        if stride.last == 0 or stride.trusted >= _MOST_TRUSTED:
            return False
        for j in range(FIRST + 1):
            added = stride.added[j]
            if added[CHANGES] + added[VOLTAGE_LIMITED_S] + added[SUPPLY_LIMITED_S] > 0.0:
                return False
        expected *= max(1.0, stride.count / stride.rate_count)
        stride.trusted += 1
    return bool(stride.sloped == 0 and expected <= _EXPECTED * tolerance)


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
    _estimate(cell, stride, tolerance)
    return _RUN if stride.error < 1.0 else _SHORTEN


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
    # What was too long would be so again.
    factor = min(stride.factor, 1.0) if stride.shortened == 1 else stride.factor
    stride.proposal = max(count * factor, float(_FEWEST))
    stride.last, stride.refused = count, 0.0
    stride.taken += 1
    run.edges += count * program.segments[course]
