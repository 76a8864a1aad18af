"""Charges side by side in arrays, and the compiled loop that runs them one after the other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from pipeline.charge.books import GAINS, new_book
from pipeline.charge.controller import Control
from pipeline.charge.drive import run_program
from pipeline.charge.period import new_clock
from pipeline.charge.program import Program
from pipeline.charge.record_keeping import PHASE_COLUMNS, SAMPLE_COLUMNS, SUMS, WAVEFORM_COLUMNS, Book
from pipeline.charge.room import room_for
from pipeline.charge.settling import Settled, settle
from pipeline.charge.state import DEPTH, HYSTERESIS, QUANTITIES, RUN, TEMPERATURE, new_run
from pipeline.charge.stride import PARTS, STRIDE, copy, new_stride
from pipeline.jit import by_reference, inlined, kernel

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

# Columns of what a charge is run under, of where its parts lie in the arrays of all, and of what is counted.
SOC, START_K, INTERVAL_S, AMBIENT_K, TOLERANCE, MOST_STEP_S, CONDITIONS = range(7)
CELL, PROGRAM, SUPPLY, MOST_STEPS, PLACES = range(5)
SAMPLES, PHASES, POINTS, MARKS, WINDOWS, PARTS_OF_BOOK = range(6)
STEPS, EDGES, CHANGES, COUNTS = range(4)


class Programs(NamedTuple):
    """Programs one behind the other, the courses of `p` from row `begin[p]` up to `begin[p + 1]`."""

    begin: Whole
    segments: Whole
    length_s: Array
    current_a: Array
    charging: NDArray[np.bool_]
    limit_v: Array
    limits: Array
    elapsed_s: Array
    group: Whole
    sampled: NDArray[np.bool_]
    averaged: NDArray[np.bool_]
    power_w: Array
    stop_elapsed_s: Array
    lift: Array


class Lot(NamedTuple):
    """Charges in arrays, a row each, and what came of them.

    conditions, places : what each is run under, and which cell, program and supply it takes.
    supply_begin : of each supply, the row of its first time; one more than there are.
    begin, end : rows of samples, phases, points, marks and windows that are each charge's own.
    start, state, at : state at the start and at the end, and the last step's quantities.
    settled : numbers of `Settled`.
    turn : the row that is run next, whichever thread comes first; an array of one.
    """

    cells: NDArray[Any]
    programs: Programs
    conditions: Array
    places: Whole
    supply_begin: Whole
    supply_time_s: Array
    supply_power_w: Array
    begin: Whole
    end: Whole
    samples: Array
    phases: Array
    waveform: Array
    marks: Array
    windows: Array
    filled: Whole
    sums: Array
    extremes: Array
    totals: Array
    gains: Array
    recent_gains: Array
    peak_k: Array
    start: Array
    state: Array
    at: Array
    settled: Array
    counts: Whole
    end_s: Array
    status: Whole
    turn: Whole

    def book(self, row: int) -> Book:
        """Return what a charge has written."""
        a, b = self.begin[row].tolist(), self.end[row].tolist()
        return Book(
            self.samples[a[SAMPLES] : b[SAMPLES]],
            self.phases[a[PHASES] : b[PHASES]],
            self.waveform[a[POINTS] : b[POINTS]],
            self.marks[a[MARKS] : b[MARKS]],
            self.windows[a[WINDOWS] : b[WINDOWS]],
            self.filled[row],
            self.sums[row],
            self.extremes[row],
            self.totals[row],
            self.gains[row],
            self.recent_gains[row],
            self.peak_k[row],
        )


class Desk(NamedTuple):
    """What one thread runs charges on: the records of a run, as they are, as words, and as they are when fresh."""

    runs: NDArray[Any]
    run_words: Array
    fresh_run: Array
    strides: NDArray[Any]
    stride_words: Array
    fresh_stride: Array
    clocks: NDArray[Any]
    clock_words: Array
    own_clocks: NDArray[Any]
    own_words: Array
    fresh_clock: Array
    scratch: Book


def new_desk() -> Desk:
    """Return a desk that nothing has been run on."""
    made: list[Any] = []
    for record in (new_run(), new_stride()):
        array = by_reference(record)
        words = array.view(np.float64)
        made += [array, words, words.copy()]
    for _ in range(2):
        array = by_reference(new_clock(np.inf))
        made += [array, array.view(np.float64)]
    return Desk(*made, made[-1].copy(), new_book(0, 0, 0, np.zeros((0, 3)), np.zeros((0, 2))))  # type: ignore[call-arg]


def pack_programs(programs: list[Program]) -> Programs:
    """Return programs one behind the other."""
    begin = np.cumsum([0, *(len(program.segments) for program in programs)], dtype=np.int64)
    arrays = (np.concatenate(parts) for parts in zip(*(program[:11] for program in programs), strict=True))
    lift = np.array([program[12:] for program in programs])
    stop_s = np.array([program.stop_elapsed_s for program in programs])
    return Programs(begin, *arrays, stop_s, lift)  # type: ignore[call-arg]


def new_lot(
    cells: NDArray[Any],
    programs: Programs,
    supplies: tuple[Whole, Array, Array],
    conditions: Array,
    places: Whole,
    rooms: Whole,
    marks: Array,
    windows: Array,
) -> Lot:
    """Return charges that have not begun.

    Arguments
    ---------
    rooms : rows of samples, phases, points, marks and windows of each charge, (n, 5).
    marks, windows : those of all charges, one behind the other.
    """
    count = len(conditions)
    end = np.cumsum(rooms, axis=0)
    most = end[-1]
    return Lot(
        cells, programs, conditions, places, *supplies, end - rooms, end,
        room_for(int(most[SAMPLES]), SAMPLE_COLUMNS), np.empty((most[PHASES], PHASE_COLUMNS)),
        np.empty((most[POINTS], WAVEFORM_COLUMNS)), marks, windows,
        np.zeros((count, 4), dtype=np.int64), np.zeros((count, SUMS)), np.zeros((count, 4)), np.zeros((count, SUMS)),
        np.zeros((count, GAINS)), np.zeros((count, GAINS)), np.zeros((count, 1)), np.zeros((count, PARTS)),
        np.zeros((count, PARTS)), np.zeros((count, QUANTITIES, 4)), np.zeros((count, len(Settled._fields))),
        np.zeros((count, COUNTS), dtype=np.int64),
        np.zeros(count), np.zeros(count, dtype=np.int64), np.zeros(1, dtype=np.int64),
    )  # fmt: skip


# Words of a run and of strides that are written before they are read, and most of both.
_WEIGHTS = RUN.fields["decay"][1] // 8, RUN.fields["phi"][1] // 8  # type: ignore[index]
_SYSTEM = STRIDE.fields["matrix"][1] // 8, STRIDE.fields["right"][1] // 8  # type: ignore[index]


@inlined
def _renew(words: Array, fresh: Array, written: tuple[int, int]) -> None:
    """Make words what they are when fresh, but for those that are written before they are read."""
    copy(words[: written[0]], fresh[: written[0]])
    copy(words[written[1] :], fresh[written[1] :])


@inlined
def _clear(scratch: Book) -> None:
    scratch.filled[:] = 0
    for n in range(len(scratch.sums)):
        scratch.sums[n] = scratch.totals[n] = 0.0
    for n in range(len(scratch.gains)):
        scratch.gains[n] = scratch.recent_gains[n] = 0.0
    scratch.extremes[:] = 0.0
    scratch.peak_k[0] = 0.0


@intrinsic
def _take_turn(typing: Any, counter: Any) -> Any:
    """Return the number in an array of one and raise it by one, in one go: no two threads get the same."""

    def made(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", array.data, context.get_constant(types.int64, 1), "seq_cst")

    return types.int64(counter), made


@kernel
def run_lot(lot: Lot, desk: Desk, control: Control) -> None:
    """Run charges of a lot, each to its end or to where it cannot go on, until none is left that nobody has begun.

    Arguments
    ---------
    desk : of this thread alone.
    control : one that is never asked.
    """
    programs, place = lot.programs, desk.scratch
    run, clock = desk.runs[0], desk.clocks[0]
    while True:
        row: int = _take_turn(lot.turn)  # type: ignore[call-arg]
        if row >= len(lot.status):
            break
        _renew(desk.run_words, desk.fresh_run, _WEIGHTS)
        _renew(desk.stride_words, desk.fresh_stride, _SYSTEM)
        copy(desk.clock_words, desk.fresh_clock)
        copy(desk.own_words, desk.fresh_clock)
        _clear(place)
        c, p, s = lot.places[row, CELL], lot.places[row, PROGRAM], lot.places[row, SUPPLY]
        conditions, a, b = lot.conditions[row], lot.begin[row], lot.end[row]
        clock.sample_interval_s = conditions[INTERVAL_S]
        run.state[DEPTH], run.state[TEMPERATURE] = 1.0 - conditions[SOC], conditions[START_K]
        run.state[HYSTERESIS] = lot.cells[c].hysteresis_start_v
        copy(lot.start[row], run.state)
        lot.peak_k[row, 0] = conditions[START_K]
        i, j = programs.begin[p], programs.begin[p + 1]
        lift = programs.lift[p]
        program = Program(
            programs.segments[i:j],
            programs.length_s[i:j],
            programs.current_a[i:j],
            programs.charging[i:j],
            programs.limit_v[i:j],
            programs.limits[i:j],
            programs.elapsed_s[i:j],
            programs.group[i:j],
            programs.sampled[i:j],
            programs.averaged[i:j],
            programs.power_w[i:j],
            programs.stop_elapsed_s[p],
            lift[0],
            lift[1],
            lift[2],
            lift[3],
        )
        book = Book(
            lot.samples[a[SAMPLES] : b[SAMPLES]],
            lot.phases[a[PHASES] : b[PHASES]],
            lot.waveform[a[POINTS] : b[POINTS]],
            lot.marks[a[MARKS] : b[MARKS]],
            lot.windows[a[WINDOWS] : b[WINDOWS]],
            lot.filled[row],
            lot.sums[row],
            lot.extremes[row],
            lot.totals[row],
            lot.gains[row],
            lot.recent_gains[row],
            lot.peak_k[row],
        )
        t, u = lot.supply_begin[s], lot.supply_begin[s + 1]
        lot.status[row] = run_program(
            lot.cells[c : c + 1], program, control, lot.supply_time_s[t:u], lot.supply_power_w[t:u], desk.runs, book,
            desk.clocks, desk.strides, desk.own_clocks, place, conditions[AMBIENT_K], conditions[TOLERANCE],
            conditions[MOST_STEP_S], lot.places[row, MOST_STEPS], None,
        )  # fmt: skip
        copy(lot.state[row], run.state)
        taken = lot.samples[a[SAMPLES] : a[SAMPLES] + lot.filled[row, 0]]
        settle(lot.cells[c : c + 1], lot.gains[row], lot.start[row], lot.state[row], taken, lot.settled[row])
        lot.end_s[row] = clock.time_s
        lot.counts[row, STEPS], lot.counts[row, EDGES] = run.steps, run.edges
        lot.counts[row, CHANGES] = run.changes
        for n in range(QUANTITIES):
            for k in range(4):
                lot.at[row, n, k] = run.at[n, k]
