"""Periods of a course, from edge to edge of the waveform: the one function both drivers run.

An endless segment is a period that ends with its course.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell
from pipeline.charge.leaking import cross_leaking, is_leaking
from pipeline.charge.plain import cross, is_plain
from pipeline.charge.program import Program, lift_line
from pipeline.charge.record_keeping import (
    Book,
    add_step,
    meets_window,
    note_marks,
    passes_mark,
    take_sample,
    write_windows,
)
from pipeline.charge.segment import (
    EDGE,
    ELAPSED,
    FAILED,
    LIMITS,
    NOTHING,
    TO_CURRENT,
    WATCHED,
    advance,
    choose_control,
    clear_at_start,
    commit,
    continue_moment,
    guard_at_start,
)
from pipeline.charge.state import DEPTH, TEMPERATURE, Demand, Run
from pipeline.charge.watching import look_at_start, peak_until, renew_peak
from pipeline.jit import inlined, kernel, new_record

EXHAUSTED = -3
TICK = 1e-9
_FIRST_STEP_S = 1e-3

CLOCK = np.dtype(
    [
        ("time_s", np.float64),
        ("course_start_s", np.float64),
        ("phase_end_s", np.float64),
        ("period_s", np.float64),
        ("sample_interval_s", np.float64),
        ("next_sample", np.int64),
        ("periods", np.int64),
        ("supply", np.int64),
        ("group", np.int64),
    ],
    align=True,
)
"""Where a run stands: time, the course's start and end, what is due next, periods done, place in the supply."""

Clock = Any


def new_clock(sample_interval_s: float) -> Clock:
    """Return the clock of a run that has not begun."""
    clock = new_record(CLOCK)
    clock["sample_interval_s"], clock["next_sample"], clock["phase_end_s"] = sample_interval_s, 1, math.inf
    return clock


@inlined
def run_periods(
    cell: Cell,
    program: Program,
    supply_time_s: NDArray[np.float64],
    supply_power_w: NDArray[np.float64],
    run: Run,
    book: Book,
    clock: Clock,
    course: int,
    count: int,
    ambient_k: float,
    tolerance: float,
    maximum_step_s: float,
    maximum_steps: int,
    crossing: int | None,
) -> int:
    """Run periods of a course; return what ended it, or `NOTHING` after so many periods, `FAILED` or `EXHAUSTED`.

    Arguments
    ---------
    crossing : anything where whole segments may be crossed in closed form; None where all are endless.
    """
    interval_s, supply, group = clock.sample_interval_s, clock.supply, clock.group
    course_start_s, phase_end_s, period_s = clock.course_start_s, clock.phase_end_s, clock.period_s
    time_s, next_sample, periods = clock.time_s, clock.next_sample, clock.periods
    last = periods + count
    limits = program.limits[course]
    watched = limits[WATCHED] > 0.0
    plain, leaking = is_plain(cell) and not watched, is_leaking(cell) and not watched
    segments, power_w = program.segments[course], program.power_w[course]
    proposals = run.proposal_s
    reason = NOTHING
    while reason == NOTHING and periods < last:
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
                if time_s >= next_sample * interval_s - TICK:
                    take_sample(cell, run, book, time_s, group)
                    next_sample += 1
                if time_s >= program.stop_elapsed_s - TICK:
                    reason = LIMITS + ELAPSED
                    break
                if time_s >= phase_end_s - TICK:
                    reason = ELAPSED
                    break
                while supply + 1 < len(supply_time_s) and time_s >= supply_time_s[supply + 1] - TICK:
                    supply += 1
                    fresh = True
                run.supplied = supply_power_w[supply] < power_w
                lift_v, lift_v_k, lowest_k, highest_k = lift_line(program, run.state[TEMPERATURE])
                run.lift_v_k = lift_v_k
                demand = Demand(
                    program.current_a[course, segment],
                    program.limit_v[course],
                    min(power_w, supply_power_w[supply]),
                    program.charging[course, segment],
                    lift_v,
                    lift_v_k,
                    lowest_k,
                    highest_k,
                )
                due_s = min(next_sample * interval_s, program.stop_elapsed_s, phase_end_s)
                if supply + 1 < len(supply_time_s):
                    due_s = min(due_s, supply_time_s[supply + 1])
                if crossing is not None:
                    whole = remaining_s == length_s and due_s >= time_s + length_s - TICK
                    if (
                        (plain or leaking)
                        and whole
                        and not meets_window(book, time_s, time_s + length_s)
                        and (
                            cross(cell, run, book, demand, limits, ambient_k, length_s)
                            if plain
                            else cross_leaking(cell, run, book, demand, limits, ambient_k, length_s, tolerance)
                        )
                    ):
                        run.steps += 1
                        time_s, remaining_s = segment_start_s + length_s, 0.0
                        if run.steps > maximum_steps:
                            clock.time_s = time_s
                            return EXHAUSTED
                        continue
                if fresh:
                    if not choose_control(cell, run, demand):
                        clock.time_s = time_s
                        return FAILED
                    if watched:
                        renew_peak(run, demand.current_a)
                        look_at_start(cell, run, ambient_k)
                    if not clear_at_start(run, demand, limits):
                        gap, what = guard_at_start(cell, run, demand, limits)
                        if gap <= 0.0 and 0 <= what <= EDGE:
                            reason = what
                            break
                    proposal_s = proposals[segment, run.control]
                    if proposal_s == math.inf:
                        proposal_s = min(length_s, maximum_step_s if length_s < math.inf else _FIRST_STEP_S)
                    fresh, first = False, True
                elif not continue_moment(cell, run, demand):
                    clock.time_s = time_s
                    return FAILED
                if watched:
                    look_at_start(cell, run, ambient_k)
                longest_s = min(maximum_step_s, remaining_s)
                if due_s - time_s < longest_s - TICK:
                    longest_s = due_s - time_s
                taken_s, what, factor = advance(cell, run, demand, limits, ambient_k, longest_s, proposal_s, tolerance)
                if what == FAILED:
                    clock.time_s = time_s
                    return FAILED
                if run.steps > maximum_steps:
                    clock.time_s = time_s
                    return EXHAUSTED
                if passes_mark(book, run.end[DEPTH]):
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
    clock.time_s, clock.next_sample, clock.periods, clock.supply = time_s, next_sample, periods, supply
    return int(reason)


# Called once a course: compiled into its caller it would be compiled twice.
run_endless = kernel(run_periods.py_func)  # type: ignore[attr-defined]


@kernel
def dyadic(wish_s: float, length_s: float) -> float:
    """Return the largest step of a finite segment that is its length halved some times, so that weights serve again."""
    if length_s == math.inf or wish_s >= length_s:
        return min(wish_s, length_s)
    return length_s * 2.0 ** math.floor(math.log2(wish_s / length_s) + 1e-9)
