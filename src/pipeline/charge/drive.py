"""The drivers: a program course by course, periods from edge to edge or many of them in one stride."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.charge.averaged import begin_strides, next_periods
from pipeline.charge.controller import Control, begin, next_current
from pipeline.charge.period import EXHAUSTED, TICK, run_endless, run_periods
from pipeline.charge.program import Program
from pipeline.charge.record_keeping import VOLTAGE_LIMITED_S, Book, reset_extremes, take_sample
from pipeline.charge.segment import EDGE, FAILED, LIMITS, NOTHING
from pipeline.charge.state import DEPTH, TEMPERATURE
from pipeline.charge.watching import NO_PEAK
from pipeline.jit import inlined, kernel

DONE, CIRCUIT_FAILED, STEPS_EXHAUSTED = range(3)
_ENDLESS = 1 << 62


@inlined
def _log(book: Book, scratch: Book, of_stride: bool) -> Book:
    """Return the book for periods that are run: of a stride, sums and extremes are another's, and nothing falls due.

    The arrays that both share are not chosen between: that would cost as much as a segment.
    """
    marks, windows = (0, 0) if of_stride else (len(book.marks), len(book.windows))
    return Book(
        book.samples,
        book.phases,
        book.waveform,
        book.marks[:marks],
        book.windows[:windows],
        book.filled,
        scratch.sums if of_stride else book.sums,
        scratch.extremes if of_stride else book.extremes,
        book.totals,
        book.gains,
        scratch.recent_gains if of_stride else book.recent_gains,
        scratch.peak_k if of_stride else book.peak_k,
    )


@kernel
def run_program(
    cells: NDArray[Any],
    program: Program,
    control: Control | None,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    runs: NDArray[Any],
    book: Book,
    clocks: NDArray[Any],
    stride_records: NDArray[Any] | None,
    own_clocks: NDArray[Any] | None,
    scratch: Book | None,
    ambient_k: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
    endless: int | None,
) -> int:
    """Run a program to its end; return how it went; the clock tells when.

    Arguments
    ---------
    cells : the battery's `Cell`; it and the other records come each in an array of one (`jit.by_reference`).
    control : what decides the currents of sampled courses.
    supply_time_s, supply_power_w : power at the terminals, constant from each time on, (m,).
    runs, book, clocks : state to start from, arrays to write into, time.
    stride_records, own_clocks, scratch : what strides need: their record, and clock and book of the periods at their
        nodes.
    endless : None; or anything where all segments are endless: then control and what strides need are None, and what
        periods need is not compiled, which halves the time until a first charge.
    """
    cell, run, clock = cells[0], runs[0], clocks[0]
    group_start_s = 0.0
    reset_extremes(book)
    # Not literals: numba would compile what takes them twice.
    course, nothing = int(np.int64(0)), int(np.int64(NOTHING))
    clock.group = -1
    while course < len(program.segments):
        if program.group[course] != clock.group:
            clock.group = program.group[course]
            group_start_s = clock.time_s
        clock.course_start_s, clock.periods = clock.time_s, 0
        start_depth = run.state[DEPTH]
        clock.phase_end_s = group_start_s + program.elapsed_s[course]
        clock.period_s = 0.0
        for n in range(program.segments[course]):
            clock.period_s += program.length_s[course, n]
        run.proposal_s[:] = math.inf
        run.memory[:] = 0.0
        if stride_records is not None:
            begin_strides(stride_records[0])
        sampled = program.sampled[course]
        if not run.resumed:
            run.peak_v, run.peak_a = NO_PEAK, 0.0
            # By itself, so that it is left out where there is none.
            if control is not None:  # noqa: SIM102
                if sampled:
                    begin(control)
        run.resumed = False
        reason = ended = nothing
        while reason == NOTHING:
            # Branches on None are left out where the argument is: they stand by themselves.
            if endless is not None:
                reason = run_endless(
                    cell, program, supply_time_s, supply_power_w, run, book, clock, course, _ENDLESS, ambient_k,
                    tolerance, maximum_step_s, maximum_steps, None,
                )  # fmt: skip
            if stride_records is not None:
                count = _ENDLESS
                if sampled:
                    count = 1
                    # At its end nothing follows that a sample would decide.
                    if clock.time_s < min(program.stop_elapsed_s, clock.phase_end_s) - TICK:
                        program.current_a[course, 0] = next_current(control, run.state[TEMPERATURE])  # type: ignore[arg-type]
                elif program.averaged[course]:
                    count = next_periods(
                        cell, program, supply_time_s, run, book, clock, stride_records[0], own_clocks[0], scratch,  # type: ignore[index,arg-type]
                        course, ended, tolerance, maximum_step_s,
                    )  # fmt: skip
                of_stride = count == 0
                ended = run_periods(
                    cell, program, supply_time_s, supply_power_w, run, _log(book, scratch, of_stride),  # type: ignore[arg-type]
                    own_clocks[0] if of_stride else clock, course, max(count, 1), ambient_k, tolerance, maximum_step_s,  # type: ignore[index]
                    maximum_steps, 1,
                )  # fmt: skip
                if not of_stride:
                    reason = ended
        if reason == FAILED:
            return CIRCUIT_FAILED
        if reason == EXHAUSTED:
            return STEPS_EXHAUSTED
        row = book.phases[book.filled[1]]
        row[0], row[1], row[2], row[3], row[4] = clock.group, clock.course_start_s, clock.time_s, reason, start_depth
        row[5], row[6], row[7] = run.state[DEPTH], run.state[TEMPERATURE], course
        row[8] = book.totals[VOLTAGE_LIMITED_S] + book.sums[VOLTAGE_LIMITED_S]
        book.filled[1] += 1
        if LIMITS <= reason < EDGE:
            break
        course += 1
        while reason != EDGE and course < len(program.segments) and program.group[course] == clock.group:
            course += 1
    take_sample(cell, run, book, clock.time_s, clock.group)
    return DONE
