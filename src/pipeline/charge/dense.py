"""What a stride writes down: samples, marks, sums, the state at its end."""

from __future__ import annotations

from pipeline.cell.circuit import Cell
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
)
from pipeline.charge.state import DEPTH, TEMPERATURE, Run
from pipeline.charge.stride import (
    CHANGES,
    END,
    FIRST,
    GAINS_FROM,
    PEAK_K,
    Stride,
    at_node_fraction,
    highest,
    passed_by,
)
from pipeline.jit import inlined, kernel


@kernel
def serve(cell: Cell, run: Run, book: Book, clock: Clock, stride: Stride, count: int) -> None:
    """Write what falls due in an accepted stride, and make its end the state of the run."""
    begin_s, length_s = clock.time_s, count * clock.period_s
    clock.periods += count
    clock.time_s = clock.course_start_s + clock.periods * clock.period_s
    _note_marks(book, stride, count, begin_s, length_s)
    done = 0.0
    while clock.next_sample * clock.sample_interval_s < clock.time_s - TICK:
        time_s = clock.next_sample * clock.sample_interval_s
        theta = max(done, (time_s - begin_s) / length_s)
        _add_span(book, stride, count, done, theta, clock.period_s)
        run.state[DEPTH] = _part_at(stride, DEPTH, count, theta)
        run.state[TEMPERATURE] = _part_at(stride, TEMPERATURE, count, theta)
        take_sample(cell, run, book, time_s, clock.group)
        clock.next_sample += 1
        done = theta
    _add_span(book, stride, count, done, 1.0, clock.period_s)
    changes = 0.0
    for node in range(3):
        changes += passed_by(count, 1.0, node) * stride.added[node, CHANGES]
    run.changes += int(changes + 0.5)
    for k in range(stride.parts):
        run.state[k] = stride.place[END, k]


@inlined
def _part_at(stride: Stride, part: int, count: int, theta: float) -> float:
    """Return depth of discharge or temperature at a fraction of the stride."""
    value = stride.before[part]
    for node in range(3):
        value += passed_by(count, theta, node) * stride.forcing[node, part]
    return float(value)


@inlined
def _note_marks(book: Book, stride: Stride, count: int, begin_s: float, length_s: float) -> None:
    while passes_mark(book, stride.place[END, DEPTH]):
        mark = book.marks[book.filled[3]]
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if _part_at(stride, DEPTH, count, middle) <= mark[0]:
                high = middle
            else:
                low = middle
        mark[1] = begin_s + high * length_s
        mark[2] = _part_at(stride, TEMPERATURE, count, high)
        book.filled[3] += 1


@kernel
def _add_span(book: Book, stride: Stride, count: int, begin: float, end: float, period_s: float) -> None:
    """Add what was added between two fractions of the stride to the sums since the last sample."""
    if end <= begin:
        return
    a = passed_by(count, end, 0) - passed_by(count, begin, 0)
    b = passed_by(count, end, 1) - passed_by(count, begin, 1)
    c = passed_by(count, end, 2) - passed_by(count, begin, 2)
    added = stride.added
    book.sums[SPAN_S] += (end - begin) * count * period_s
    for n in range(SPAN_S + 1, SUMS):
        book.sums[n] += a * added[0, n] + b * added[1, n] + c * added[2, n]
    for n in range(len(book.recent_gains)):
        m = GAINS_FROM + n
        book.recent_gains[n] += a * added[0, m] + b * added[1, m] + c * added[2, m]
    for theta in (begin, end):
        for n in (LOWEST_V, LOWEST_A):
            book.extremes[n] = min(book.extremes[n], _seen_at(stride, n, theta))
        for n in (HIGHEST_V, HIGHEST_A):
            book.extremes[n] = max(book.extremes[n], _seen_at(stride, n, theta))
    seen = stride.seen
    warmest = highest(seen[0, PEAK_K], seen[1, PEAK_K], seen[2, PEAK_K])
    book.peak_k[0] = max(book.peak_k[0], max(warmest, seen[FIRST, PEAK_K]))


@inlined
def _seen_at(stride: Stride, n: int, theta: float) -> float:
    """Return an extreme of a period at a fraction of the stride, within what was seen at its nodes and start."""
    a, b, c, d = stride.seen[0, n], stride.seen[1, n], stride.seen[2, n], stride.seen[FIRST, n]
    value = at_node_fraction(a, b, c, theta)
    return float(min(max(value, min(min(a, b), min(c, d))), max(max(a, b), max(c, d))))
