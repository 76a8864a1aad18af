"""What a stride writes down: samples, marks, sums, the state at its end."""

from __future__ import annotations

from typing import NamedTuple

from pipeline.cell.circuit import Cell
from pipeline.cell.relaxation import LAGRANGE
from pipeline.charge.period import TICK, Clock
from pipeline.charge.record_keeping import (
    HIGHEST_A,
    HIGHEST_V,
    LOWEST_A,
    LOWEST_V,
    SPAN_S,
    SUMS,
    Book,
    passes_mark,
    take_sample,
    widen,
)
from pipeline.charge.state import DEPTH, TEMPERATURE, Run
from pipeline.charge.stride import (
    CHANGES,
    END,
    FIRST,
    GAINS_FROM,
    PEAK_K,
    Stride,
    highest,
    passed_by,
)
from pipeline.jit import inlined, kernel


class Moment(NamedTuple):
    """A moment of a stride: the sums up to it of what is 1 at one node, and what is seen of a period there."""

    a: float
    b: float
    c: float
    lowest_v: float
    highest_v: float
    lowest_a: float
    highest_a: float


@kernel
def serve(cell: Cell, run: Run, book: Book, clock: Clock, stride: Stride, count: int) -> None:
    """Write what falls due in an accepted stride, and make its end the state of the run."""
    begin_s, length_s = clock.time_s, count * clock.period_s
    clock.periods += count
    clock.time_s = clock.course_start_s + clock.periods * clock.period_s
    _note_marks(book, stride, count, begin_s, length_s)
    seen = stride.seen
    peak_k = max(highest(seen[0, PEAK_K], seen[1, PEAK_K], seen[2, PEAK_K]), seen[FIRST, PEAK_K])
    done, before = 0.0, _moment(stride, count, 0.0)
    while clock.next_sample * clock.sample_interval_s < clock.time_s - TICK:
        time_s = clock.next_sample * clock.sample_interval_s
        theta = max(done, (time_s - begin_s) / length_s)
        here = _moment(stride, count, theta)
        _add_span(book, stride, count, done, theta, clock.period_s, before, here, peak_k)
        run.state[DEPTH] = _part_at(stride, DEPTH, here)
        run.state[TEMPERATURE] = _part_at(stride, TEMPERATURE, here)
        take_sample(cell, run, book, time_s, clock.group)
        clock.next_sample += 1
        done, before = theta, here
    end = _moment(stride, count, 1.0)
    _add_span(book, stride, count, done, 1.0, clock.period_s, before, end, peak_k)
    changes = end.a * stride.added[0, CHANGES] + end.b * stride.added[1, CHANGES] + end.c * stride.added[2, CHANGES]
    run.changes += int(changes + 0.5)
    for k in range(stride.parts):
        run.state[k] = stride.place[END, k]


@inlined
def _moment(stride: Stride, count: int, theta: float) -> Moment:
    """Return what is known of a fraction of the stride."""
    first = LAGRANGE[0, 0] + theta * (LAGRANGE[1, 0] + theta * LAGRANGE[2, 0])
    second = LAGRANGE[0, 1] + theta * (LAGRANGE[1, 1] + theta * LAGRANGE[2, 1])
    third = LAGRANGE[0, 2] + theta * (LAGRANGE[1, 2] + theta * LAGRANGE[2, 2])
    return Moment(
        passed_by(count, theta, 0),
        passed_by(count, theta, 1),
        passed_by(count, theta, 2),
        _seen_at(stride, LOWEST_V, first, second, third),
        _seen_at(stride, HIGHEST_V, first, second, third),
        _seen_at(stride, LOWEST_A, first, second, third),
        _seen_at(stride, HIGHEST_A, first, second, third),
    )


@inlined
def _part_at(stride: Stride, part: int, at: Moment) -> float:
    """Return depth of discharge or temperature at a moment of the stride."""
    value = stride.before[part] + at.a * stride.forcing[0, part]
    return float(value + at.b * stride.forcing[1, part] + at.c * stride.forcing[2, part])


@inlined
def _note_marks(book: Book, stride: Stride, count: int, begin_s: float, length_s: float) -> None:
    while passes_mark(book, stride.place[END, DEPTH]):
        mark = book.marks[book.filled[3]]
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if _part_at(stride, DEPTH, _moment(stride, count, middle)) <= mark[0]:
                high = middle
            else:
                low = middle
        mark[1] = begin_s + high * length_s
        mark[2] = _part_at(stride, TEMPERATURE, _moment(stride, count, high))
        book.filled[3] += 1


@inlined
def _add_span(
    book: Book,
    stride: Stride,
    count: int,
    begin: float,
    end: float,
    period_s: float,
    before: Moment,
    after: Moment,
    peak_k: float,
) -> None:
    """Add what was added between two fractions of the stride to the sums since the last sample."""
    if end <= begin:
        return
    a, b, c = after.a - before.a, after.b - before.b, after.c - before.c
    added, sums, gains = stride.added, book.sums, book.recent_gains
    sums[SPAN_S] += (end - begin) * count * period_s
    for n in range(SPAN_S + 1, SUMS):
        sums[n] += a * added[0, n] + b * added[1, n] + c * added[2, n]
    for n in range(len(gains)):
        m = GAINS_FROM + n
        gains[n] += a * added[0, m] + b * added[1, m] + c * added[2, m]
    lowest_v, highest_v = min(before.lowest_v, after.lowest_v), max(before.highest_v, after.highest_v)
    lowest_a, highest_a = min(before.lowest_a, after.lowest_a), max(before.highest_a, after.highest_a)
    widen(book.extremes, lowest_v, highest_v, lowest_a, highest_a)
    book.peak_k[0] = max(book.peak_k[0], peak_k)


@inlined
def _seen_at(stride: Stride, n: int, first: float, second: float, third: float) -> float:
    """Return an extreme of a period by the values of the basis functions, within what was seen at nodes and start."""
    a, b, c, d = stride.seen[0, n], stride.seen[1, n], stride.seen[2, n], stride.seen[FIRST, n]
    value = a * first + b * second + c * third
    return float(min(max(value, min(min(a, b), min(c, d))), max(max(a, b), max(c, d))))
