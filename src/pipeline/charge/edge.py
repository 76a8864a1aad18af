"""The `edge` driver: from edge to edge of the waveform, every stop located, samples where they are due."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.charge.controller import Control, begin, next_current
from pipeline.charge.program import Program
from pipeline.charge.record_keeping import Book, add_step, note_marks, reset_extremes, take_sample, write_windows
from pipeline.charge.segment import (
    EDGE,
    ELAPSED,
    FAILED,
    LIMITS,
    NOTHING,
    TO_CURRENT,
    WATCHED,
    Demand,
    advance,
    choose_control,
    clear_at_start,
    commit,
    continue_moment,
    guard_at_start,
)
from pipeline.charge.state import DEPTH, TEMPERATURE, Run
from pipeline.charge.watching import NO_PEAK, look_at_start, peak_until, renew_peak
from pipeline.jit import kernel

DONE, CIRCUIT_FAILED, STEPS_EXHAUSTED = range(3)
_TICK = 1e-9
_FIRST_STEP_S = 1e-3


@kernel
def run_edge(
    cell: Cell,
    program: Program,
    control: Control,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    run: Run,
    book: Book,
    ambient_k: float,
    sample_interval_s: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
) -> tuple[int, float]:
    """Run a program to its end; return how it went and the time it ended [s].

    Arguments
    ---------
    control : what decides the currents of sampled courses.
    supply_time_s, supply_power_w : power at the terminals, constant from each time on, (m,).
    run, book : state to start from, arrays to write into.
    """
    time_s, group_start_s, next_sample = 0.0, 0.0, 1
    supply = 0
    proposals = run.proposal_s
    reset_extremes(book)
    course, group = 0, -1
    while course < len(program.segments):
        if program.group[course] != group:
            group = program.group[course]
            group_start_s = time_s
        course_start_s, start_depth = time_s, run.state[DEPTH]
        phase_end_s = group_start_s + program.elapsed_s[course]
        limits = program.limits[course]
        watched = limits[WATCHED] > 0.0
        run.peak_v, run.peak_a = NO_PEAK, 0.0
        segments = program.segments[course]
        period_s = 0.0
        for n in range(segments):
            period_s += program.length_s[course, n]
        proposals[:] = math.inf
        run.memory[:] = 0.0
        reason, periods = NOTHING, 0
        sampled = program.sampled[course]
        if sampled:
            begin(control)
        while reason == NOTHING:
            if sampled:
                program.current_a[course, 0] = next_current(control, run.state[TEMPERATURE])
            offset_s = 0.0
            for segment in range(segments):
                length_s = program.length_s[course, segment]
                segment_start_s = course_start_s + offset_s + (periods * period_s if periods > 0 else 0.0)
                offset_s += length_s
                time_s = segment_start_s
                remaining_s = length_s
                run.edges += 1
                run.segment, run.place = segment, 0
                fresh, first = True, True
                while remaining_s > 0.0 and reason == NOTHING:
                    if time_s >= next_sample * sample_interval_s - _TICK:
                        take_sample(cell, run, book, time_s, group)
                        next_sample += 1
                    if time_s >= program.stop_elapsed_s - _TICK:
                        reason = LIMITS + ELAPSED
                        break
                    if time_s >= phase_end_s - _TICK:
                        reason = ELAPSED
                        break
                    while supply + 1 < len(supply_time_s) and time_s >= supply_time_s[supply + 1] - _TICK:
                        supply += 1
                        fresh = True
                    demand = Demand(
                        program.current_a[course, segment],
                        program.limit_v[course],
                        supply_power_w[supply],
                        program.charging[course, segment],
                    )
                    if fresh:
                        if not choose_control(cell, run, demand):
                            return CIRCUIT_FAILED, time_s
                        if watched:
                            renew_peak(run, demand.current_a)
                            look_at_start(cell, run, ambient_k)
                        if not clear_at_start(run, limits):
                            gap, what = guard_at_start(cell, run, demand, limits)
                            if gap <= 0.0 and 0 <= what <= EDGE:
                                reason = what
                                break
                        proposal_s = proposals[segment, run.control]
                        if proposal_s == math.inf:
                            proposal_s = min(length_s, maximum_step_s if length_s < math.inf else _FIRST_STEP_S)
                        fresh, first = False, True
                    elif not continue_moment(cell, run, demand):
                        return CIRCUIT_FAILED, time_s
                    if watched:
                        look_at_start(cell, run, ambient_k)
                    due_s = min(next_sample * sample_interval_s, program.stop_elapsed_s, phase_end_s)
                    if supply + 1 < len(supply_time_s):
                        due_s = min(due_s, supply_time_s[supply + 1])
                    longest_s = min(maximum_step_s, remaining_s)
                    if due_s - time_s < longest_s - _TICK:
                        longest_s = due_s - time_s
                    taken_s, what, factor = advance(
                        cell, run, demand, limits, ambient_k, longest_s, proposal_s, tolerance
                    )
                    if what == FAILED:
                        return CIRCUIT_FAILED, time_s
                    if run.steps > maximum_steps:
                        return STEPS_EXHAUSTED, time_s
                    note_marks(cell, run, book, time_s, taken_s)
                    if len(book.windows) > 0:
                        write_windows(cell, run, book, time_s, taken_s, length_s)
                    add_step(cell, run, book, taken_s)
                    if watched:
                        run.peak_v = peak_until(run, 2)
                    commit(run)
                    if first and length_s < math.inf:
                        better = 2.0 * taken_s if factor > 2.9 else taken_s
                        if taken_s < longest_s or better > taken_s:
                            proposals[segment, run.control] = dyadic(min(better, length_s), length_s)
                    first = False
                    wish_s = max(taken_s, min(proposal_s, 4.0 * taken_s)) * factor if what == NOTHING else proposal_s
                    remaining_s -= taken_s
                    if remaining_s <= 1e-12 * length_s and length_s < math.inf:
                        remaining_s = 0.0
                    # To the end of the segment where that is near enough: the same length in every period.
                    proposal_s = min(maximum_step_s, wish_s if wish_s >= remaining_s else dyadic(wish_s, length_s))
                    time_s = segment_start_s + (length_s - remaining_s) if length_s < math.inf else time_s + taken_s
                    if what >= TO_CURRENT:
                        run.changes += 1
                        fresh = True
                    elif what != NOTHING:
                        reason = what
                if reason != NOTHING:
                    break
            periods += 1
        row = book.phases[book.filled[1]]
        row[0], row[1], row[2], row[3], row[4] = group, course_start_s, time_s, reason, start_depth
        row[5], row[6], row[7] = run.state[DEPTH], run.state[TEMPERATURE], course
        book.filled[1] += 1
        if LIMITS <= reason < EDGE:
            break
        course += 1
        while reason != EDGE and course < len(program.segments) and program.group[course] == group:
            course += 1
    take_sample(cell, run, book, time_s, group)
    return DONE, time_s


@kernel
def dyadic(wish_s: float, length_s: float) -> float:
    """Return the largest step of a finite segment that is its length halved some times, so that weights serve again."""
    if length_s == math.inf or wish_s >= length_s:
        return min(wish_s, length_s)
    return length_s * 2.0 ** math.floor(math.log2(wish_s / length_s) + 1e-9)
