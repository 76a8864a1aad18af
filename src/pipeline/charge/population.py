"""Populations of charges: prepared and checked in blocks, run as arrays by several threads.

A charge of a population is, bit for bit, the charge by itself: it runs through the same compiled program from the same
numbers. A mode is held against its sheet once for all the batteries that it charges, batteries are compiled column by
column, and tables are made when they are asked for. What samples, whose controllers keep what they have seen in arrays
of their own, runs one by one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.bank import compile_cells, new_room
from pipeline.cell.circuit import CELL, FIRST_PAIR, OPEN_CIRCUIT, ZERO_CELSIUS_K
from pipeline.cell.curves import INVERSE, LOGARITHM
from pipeline.cell.records import Battery
from pipeline.charge import drive
from pipeline.charge.books import failure, marks_of, points_of, rows_of, windows_of
from pipeline.charge.checks import check
from pipeline.charge.controller import compile_control
from pipeline.charge.ended import Ended
from pipeline.charge.lot import (
    AMBIENT_K,
    CHANGES,
    EDGES,
    START_K,
    STEPS,
    Desk,
    Lot,
    new_desk,
    new_lot,
    pack_programs,
    run_lot,
)
from pipeline.charge.outcome import Outcome
from pipeline.charge.program import Program, compile_program
from pipeline.charge.protocol import Protocol, resolve
from pipeline.charge.records import ChargeSettings, Mode
from pipeline.charge.settling import Settled
from pipeline.charge.soundness import FAULTS, FOUND, SOUND, Group, Looked, Sheet, look
from pipeline.charge.task import Charge, Supply, Task
from pipeline.errors import EngineError

BLOCK, FIRST = 128, 16
"""Charges that are prepared together; those of the first block, which nothing runs beside."""
FEW = 8
"""Charges of which fewer are run one by one: nothing is compiled for them that single ones do not need."""
AHEAD = 2
"""Blocks that are prepared before the charges of the first are wanted."""
_NO_CELLS = np.zeros(0, dtype=CELL)
# Room for cells that nobody uses: pages of its own cost more than what is written there.
_ROOMS: SimpleQueue[NDArray[Any]] = SimpleQueue()
_NO_MARKS, _NO_WINDOWS = np.zeros((0, 3)), np.zeros((0, 2))

Alone = Callable[[Task], Charge]


class Refused(NamedTuple):
    """What the check of a charge raised: battery, mode and conditions do not fit each other."""

    fault: Exception


Failure = Exception | Refused


class _Run(NamedTuple):
    """A mode on batteries of a kind, in the kernels' form."""

    protocol: Protocol
    program: Program
    samples: bool


class _Conditions(NamedTuple):
    settings: ChargeSettings
    marks: NDArray[np.float64]
    windows: NDArray[np.float64]


class _Known:
    """What charges of a population have in common, each found once."""

    def __init__(self) -> None:
        self.sheets: list[Sheet] = []
        self._sheet_of: dict[int, int] = {}
        self._by_value: dict[str, list[int]] = {}
        self._general: dict[int, bool] = {}
        self._runs: dict[tuple[object, ...], _Run] = {}
        self._settings: dict[int, _Conditions] = {}

    def sheet(self, mode: Mode) -> int:
        """Return the number of a mode among those that differ."""
        found = self._sheet_of.get(id(mode))
        if found is None:
            alike = self._by_value.setdefault(mode.model_dump_json(), [])
            found = next((n for n in alike if self.sheets[n].mode == mode), -1)
            if found < 0:
                found = len(self.sheets)
                self.sheets.append(Sheet(mode))
                alike.append(found)
            self._sheet_of[id(mode)] = found
        return found

    def conditions(self, settings: ChargeSettings) -> _Conditions:
        """Return the settings with their marks and windows as arrays."""
        found = self._settings.get(id(settings))
        if found is None:
            marks = marks_of(settings) if settings.soc_marks else _NO_MARKS
            windows = windows_of(settings) if settings.windows else _NO_WINDOWS
            found = self._settings[id(settings)] = _Conditions(settings, marks, windows)
        return found

    def run(self, sheet: int, battery: Battery, capacity_ah: float, fills: bool, driver: str) -> _Run:
        """Return a mode on a battery, in numbers; where no number is the battery's, for all of them.

        Raises
        ------
        UserError : a number is still to be found.
        """
        kind = sheet, fills, battery.cells_in_series, battery.cells_in_unit, driver
        key = kind if self._is_general(sheet) else (*kind, capacity_ah)
        found = self._runs.get(key)
        if found is None:
            protocol = resolve(self.sheets[sheet].mode, capacity_ah, fills, battery.cells)
            program = compile_program(protocol, battery.cells_in_series, driver, battery.cells_in_unit)
            found = self._runs[key] = _Run(protocol, program, bool(program.sampled.any()))
        return found

    def _is_general(self, sheet: int) -> bool:
        """Tell whether no number of a mode depends on the capacity: they are the same on another."""
        if sheet not in self._general:
            mode = self.sheets[sheet].mode
            self._general[sheet] = resolve(mode, 1.0, cells=1) == resolve(mode, 2.0, cells=1)
        return self._general[sheet]


class _Batteries(NamedTuple):
    """The batteries of a block, each object once, with what is asked of them again and again."""

    cells: NDArray[Any]
    row_of: dict[int, int]
    capacity_ah: list[float]
    series: list[int]
    fills: list[bool]


class _Block(NamedTuple):
    """Charges that can be run, a row of the lot each, what they run, and those that failed before or run one by one."""

    tasks: Sequence[Task]
    lot: Lot | None
    rows: dict[int, int]
    runs: list[_Run]
    failures: dict[int, Failure]


def charge_many(tasks: Sequence[Task], threads: int, alone: Alone) -> Iterator[Charge | Failure]:
    """Charge many batteries at once; yield each charge, or why there is none, in the order of the tasks.

    Arguments
    ---------
    threads : charges under way at once.
    alone : charges one battery; its errors are those of `simulate`.
    """
    few = len(tasks) < FEW
    # The caller's own thread charges too, once it has prepared what the others need.
    with ThreadPoolExecutor(max_workers=threads if few else max(threads - 1, 1)) as pool:
        if few:
            yield from pool.map(partial(_check_and_attempt, alone), tasks)
            return
        known, desks = _Known(), SimpleQueue[Desk]()
        for _ in range(threads):
            desks.put(new_desk())
        under_way: deque[Callable[[], list[Charge | Failure]]] = deque()
        begin, size = 0, min(FIRST, BLOCK)
        while begin < len(tasks):
            block = tasks[begin : begin + size]
            under_way.append(_start(block, known, desks, partial(_attempt, alone), threads, pool))
            begin, size = begin + size, min(2 * size, BLOCK)
            if len(under_way) > AHEAD:
                yield from under_way.popleft()()
        while under_way:
            yield from under_way.popleft()()


def _check_and_attempt(alone: Alone, task: Task) -> Charge | Failure:
    refused = _refused(task)
    return _attempt(alone, task) if refused is None else refused


def _refused(task: Task) -> Refused | None:
    try:
        check(task.battery, task.mode, task.settings)
    except FAULTS as fault:
        return Refused(fault)
    return None


def _attempt(alone: Alone, task: Task) -> Charge | Failure:
    try:
        return alone(task)
    except (*FAULTS, EngineError) as fault:
        return fault


def _start(
    tasks: Sequence[Task],
    known: _Known,
    desks: SimpleQueue[Desk],
    alone: Callable[[Task], Charge | Failure],
    threads: int,
    pool: ThreadPoolExecutor,
) -> Callable[[], list[Charge | Failure]]:
    """Prepare a block and let others run it; return what runs with them to its end and returns its charges."""
    room = _room()
    block = _prepared(tasks, known, room)
    part = None if block.lot is None else partial(_run, block.lot, block.runs[0], desks)
    by_itself = [n for n in range(len(tasks)) if n not in block.rows and n not in block.failures]
    others = 0 if part is None else min(threads, len(block.rows)) - 1
    waiting = [pool.submit(part) for _ in range(others)] if part is not None else []
    singles = {n: pool.submit(alone, tasks[n]) for n in by_itself} if threads > 1 else {}

    def finish() -> list[Charge | Failure]:
        if part is not None:
            part()
        for other in waiting:
            other.result()
        # From the end, where the others have not come to.
        own = {n: alone(tasks[n]) for n in reversed(by_itself) if threads == 1 or singles[n].cancel()}
        # What has run does not hold on to room for cells.
        done = block if block.lot is None else block._replace(lot=block.lot._replace(cells=_NO_CELLS))
        _ROOMS.put(room)
        status = [] if done.lot is None else done.lot.status.tolist()
        ended = (
            None
            if done.lot is None
            else Ended(done.lot, [tasks[n] for n in done.rows], [run.protocol for run in done.runs])
        )
        own |= {n: one.result() for n, one in singles.items() if n not in own}
        return [own[n] if n in own else _charge(done, ended, status, n) for n in range(len(tasks))]

    return finish


def _room() -> NDArray[Any]:
    try:
        found = _ROOMS.get_nowait()
    except Empty:
        return new_room(BLOCK)
    return found if len(found) >= BLOCK else new_room(BLOCK)


def _run(lot: Lot, run: _Run, desks: SimpleQueue[Desk]) -> None:
    desk = desks.get()
    run_lot(lot, desk, compile_control(run.protocol, 0.0))
    desks.put(desk)


def _charge(block: _Block, ended: Ended | None, status: Sequence[int], place: int) -> Charge | Failure:
    """Return a charge of a block that has run, or why there is none."""
    if place in block.failures:
        return block.failures[place]
    task, row, lot = block.tasks[place], block.rows[place], block.lot
    assert lot is not None
    assert ended is not None
    if status[row] != drive.DONE:
        steps = int(lot.counts[row, STEPS])
        return failure(status[row], float(lot.end_s[row]), steps, lot.state[row], task.engine)
    outcome = partial(_outcome, lot, row, block.runs[row])
    return Charge(task, outcome, partial(ended.summary, row, outcome))


def _outcome(lot: Lot, row: int, run: _Run) -> Outcome:
    """Return a finished run; without its cell, which has been written over."""
    counts = lot.counts[row].tolist()
    steps, edges, changes = counts[STEPS], counts[EDGES], counts[CHANGES]
    end = {"state": lot.state[row], "at": lot.at[row], "steps": steps, "edges": edges, "changes": changes}
    settled, end_s = Settled(*lot.settled[row].tolist()), float(lot.end_s[row])
    return Outcome(None, run.protocol, end, lot.book(row), lot.start[row], end_s, settled)


def _prepared(tasks: Sequence[Task], known: _Known, room: NDArray[Any]) -> _Block:
    """Check charges, and put those into arrays that do not run one by one."""
    batteries = _batteries(tasks, room)
    sheets = [known.sheet(task.mode) for task in tasks]
    failures = _failures(tasks, known, sheets, batteries)
    runs: dict[int, _Run] = {}
    for n, task in enumerate(tasks):
        if n in failures:
            continue
        own = batteries.row_of[id(task.battery)]
        capacity_ah, fills = batteries.capacity_ah[own], batteries.fills[own]
        try:
            run = known.run(sheets[n], task.battery, capacity_ah, fills, task.engine.driver)
        except FAULTS as fault:
            failures[n] = fault
            continue
        if not run.samples:
            runs[n] = run
    rows = {n: row for row, n in enumerate(runs)}
    lot = _lot([tasks[n] for n in runs], list(runs.values()), known, batteries) if runs else None
    return _Block(tasks, lot, rows, list(runs.values()), failures)


def _batteries(tasks: Sequence[Task], room: NDArray[Any]) -> _Batteries:
    distinct = {id(task.battery): task.battery for task in tasks}
    batteries = list(distinct.values())
    cells = compile_cells(batteries, room)
    curves = [OPEN_CIRCUIT, *range(FIRST_PAIR, cells["kind"].shape[1])]
    kind, parameters = cells["kind"][:, curves], cells["parameters"][:, curves]
    # As `Battery.fills`: no acceptance pair, and no pole where it is full.
    pole = ((kind == LOGARITHM) & (parameters[..., 3] == 0.0)) | ((kind == INVERSE) & (parameters[..., 1] == 0.0))
    fills = (cells["acceptance"] == 0) & ~pole.any(axis=1)
    return _Batteries(
        cells,
        {key: row for row, key in enumerate(distinct)},
        [battery.capacity_in_use_ah for battery in batteries],
        [battery.cells for battery in batteries],
        fills.tolist(),
    )


def _failures(tasks: Sequence[Task], known: _Known, sheets: Sequence[int], batteries: _Batteries) -> dict[int, Failure]:
    """Return what is wrong with charges, by their place."""
    own = [batteries.row_of[id(task.battery)] for task in tasks]
    alike: dict[tuple[int, int, bool], list[int]] = {}
    for n, row in enumerate(own):
        alike.setdefault((sheets[n], batteries.series[row], batteries.fills[row]), []).append(n)
    groups = {(sheet, Group(cells, fills)): members for (sheet, cells, fills), members in alike.items()}
    capacity_ah = np.array(batteries.capacity_ah)[own]
    asked, held = np.empty((len(tasks), 4)), np.zeros(len(tasks), dtype=np.bool_)
    asked[:, 0] = [task.settings.initial_soc for task in tasks]
    asked[:, 3] = [task.settings.start_c for task in tasks]
    interval_s = np.array([task.settings.sample_interval_s for task in tasks])
    for (number, group), members in groups.items():
        sheet, at = known.sheets[number], capacity_ah[members]
        low, high = sheet.visited(group, float(at.min()), float(at.max()), asked[members, 0])
        asked[members, 1], asked[members, 2], held[members] = low, high, sheet.held
    found = np.empty((len(tasks), FOUND))
    look(batteries.cells, np.array(own, dtype=np.int64), asked, held, found)
    looked = Looked(capacity_ah, interval_s, asked, found)
    doubtful = set(np.flatnonzero(found[:, SOUND] == 0.0).tolist())
    for (number, group), members in groups.items():
        clear = [n for n in members if n not in doubtful]
        doubtful |= set(known.sheets[number].doubtful(group, np.array(clear, dtype=np.int64), looked))
    checked = {n: _refused(tasks[n]) for n in doubtful}
    return {n: refused for n, refused in checked.items() if refused is not None}


def _lot(tasks: Sequence[Task], runs: Sequence[_Run], known: _Known, batteries: _Batteries) -> Lot:
    """Return charges in arrays."""
    programs = {id(run): run.program for run in runs}
    supplies = {id(task.supply): task.supply for task in tasks}
    program_of, supply_of = ({key: n for n, key in enumerate(one)} for one in (programs, supplies))
    own = [known.conditions(task.settings) for task in tasks]
    row_of = batteries.row_of
    conditions = np.array([
        (
            settings.initial_soc, settings.start_c, settings.sample_interval_s, settings.ambient_c,
            task.engine.tolerance, task.engine.maximum_step_s,
        )
        for task, (settings, _, _) in zip(tasks, own, strict=True)
    ])  # fmt: skip
    conditions[:, [START_K, AMBIENT_K]] += ZERO_CELSIUS_K
    places = np.array([
        (row_of[id(task.battery)], program_of[id(run)], supply_of[id(task.supply)], task.engine.maximum_steps)
        for task, run in zip(tasks, runs, strict=True)
    ])  # fmt: skip
    alike: dict[Any, tuple[int, ...]] = {}
    rooms = np.array([_room_of_book(run.program, of_task, alike) for run, of_task in zip(runs, own, strict=True)])
    marks, windows = np.concatenate([one.marks for one in own]), np.concatenate([one.windows for one in own])
    packed = pack_programs(list(programs.values()))
    return new_lot(batteries.cells, packed, _packed(list(supplies.values())), conditions, places, rooms, marks, windows)


def _room_of_book(program: Program, asked: _Conditions, alike: dict[Any, tuple[int, ...]]) -> tuple[int, ...]:
    """Return rows of samples, phases, points, marks and windows; `alike` holds those found before."""
    interval_s, marks, windows = asked.settings.sample_interval_s, len(asked.marks), asked.windows
    key = id(program), interval_s, marks, windows.tobytes()
    found = alike.get(key)
    if found is None:
        rows, points = rows_of(program.stop_elapsed_s, interval_s), points_of(program, windows)
        found = alike[key] = (rows, len(program.segments), points, marks, len(windows))
    return found


def _packed(supplies: Sequence[Supply]) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    begin = np.cumsum([0, *(len(supply.time_s) for supply in supplies)], dtype=np.int64)
    times, powers = [supply.time_s for supply in supplies], [supply.power_w for supply in supplies]
    return begin, np.concatenate(times).astype(np.float64), np.concatenate(powers).astype(np.float64)
