"""Charge a battery by a mode from a supply: records in, columns out; one charge, or many at once."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from pipeline.cell.circuit import ZERO_CELSIUS_K, Cell, compile_cell, enthalpy
from pipeline.cell.curves import value_and_slope
from pipeline.cell.records import Battery, Pair, SideReaction, Thermal
from pipeline.charge import drive
from pipeline.charge.books import book_for, failure, new_book
from pipeline.charge.checks import check
from pipeline.charge.controller import Control, compile_control
from pipeline.charge.lot import run_lot
from pipeline.charge.outcome import Outcome
from pipeline.charge.period import Clock, new_clock, run_endless, run_periods
from pipeline.charge.population import FEW, Refused, charge_many
from pipeline.charge.program import Program, compile_program
from pipeline.charge.protocol import resolve
from pipeline.charge.record_keeping import Book
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.settling import settled_of
from pipeline.charge.state import DEPTH, HYSTERESIS, TEMPERATURE, Run, new_run
from pipeline.charge.stride import new_stride
from pipeline.charge.task import BENCH, Charge, Supply, Task
from pipeline.charge.waveforms import Sampled
from pipeline.errors import UserError
from pipeline.jit import by_reference

__all__ = [
    "BENCH",
    "Charge",
    "Supply",
    "Task",
    "launch",
    "new_book",
    "resting_run",
    "run",
    "simulate",
    "simulate_many",
    "try_many",
    "warm_up",
]


def simulate(battery: Battery, mode: Mode, supply: Supply, settings: ChargeSettings, engine: EngineSettings) -> Charge:
    """Charge a battery.

    Arguments
    ---------
    supply : power at the terminals over time.

    Raises
    ------
    UserError : the mode does not fit the battery or the settings.
    EngineError : steps exhausted or a state without a solution.
    """
    outcome = run(battery, mode, supply, settings, engine)
    return Charge(Task(battery, mode, supply, settings, engine), lambda: outcome)


def simulate_many(tasks: Iterable[Task], threads: int | None = None) -> list[Charge]:
    """Charge many batteries at once; each charge is, bit for bit, what `simulate` makes of it.

    What they have in common is checked and compiled once; the kernels run from charge to charge without Python, whose
    lock they let go of, so that threads run as many of them as there are cores. Tables and summary of a charge are made
    when they are asked for.

    Arguments
    ---------
    tasks : the charges.
    threads : charges under way at once; as many as this process may use cores where not given.

    Returns
    -------
    The charges in the order of the tasks.

    Raises
    ------
    UserError, EngineError : as `simulate`, for the first charge that fails.
    """
    charges: list[Charge] = []
    for found in _attempts(tasks, threads):
        if isinstance(found, Charge):
            charges.append(found)
        else:
            raise found.fault if isinstance(found, Refused) else found
    return charges


def try_many(
    tasks: Iterable[Task], refusals: tuple[type[Exception], ...] = (UserError,), threads: int | None = None
) -> list[Charge | Exception]:
    """Do as `simulate_many` for charges that may not be possible: what `check` says of one stands in its place.

    Arguments
    ---------
    refusals : what `check` may raise and is returned.

    Raises
    ------
    UserError, EngineError : as `simulate`, for the first charge that fails otherwise.
    """
    charges: list[Charge | Exception] = []
    for found in _attempts(tasks, threads):
        if isinstance(found, Charge):
            charges.append(found)
        elif isinstance(found, Refused) and isinstance(found.fault, refusals):
            charges.append(found.fault)
        else:
            raise found.fault if isinstance(found, Refused) else found
    return charges


def _attempts(tasks: Iterable[Task], threads: int | None) -> Iterator[Charge | Refused | Exception]:
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    return charge_many(list(tasks), threads or count, lambda task: simulate(*task))


def run(battery: Battery, mode: Mode, supply: Supply, settings: ChargeSettings, engine: EngineSettings) -> Outcome:
    """Run the engine and return its arrays; arguments and errors are those of `simulate`."""
    check(battery, mode, settings)
    cell = compile_cell(battery)
    protocol = resolve(mode, battery.capacity_in_use_ah, battery.fills, battery.cells)
    program = compile_program(protocol, battery.cells_in_series, engine.driver, battery.cells_in_unit)
    state = resting_run(cell, settings.initial_soc, settings.start_c + ZERO_CELSIUS_K)
    start = state["state"].copy()
    book = book_for(program, settings)
    book.peak_k[0] = start[TEMPERATURE]
    control = compile_control(protocol, battery.capacity_in_use_ah)
    clock = new_clock(float(settings.sample_interval_s))
    status = launch(cell, program, control, supply, state, book, clock, settings.ambient_c + ZERO_CELSIUS_K, engine)
    end_s = float(clock["time_s"])
    if status != drive.DONE:
        raise failure(status, end_s, int(state["steps"]), state["state"], engine)
    return Outcome(
        cell, protocol, state, book, start, end_s, settled_of(by_reference(cell), book, start, state["state"])
    )


def resting_run(cell: Cell, initial_soc: float, temperature_k: float) -> Run:
    """Return the record of a run that begins at rest, its pairs discharged."""
    run = new_run()
    state = run["state"]
    state[DEPTH], state[TEMPERATURE], state[HYSTERESIS] = 1.0 - initial_soc, temperature_k, cell.hysteresis_start_v
    return run


def launch(
    cell: Cell,
    program: Program,
    control: Control,
    supply: Supply,
    state: Run,
    book: Book,
    clock: Clock,
    ambient_k: float,
    engine: EngineSettings,
) -> int:
    """Run a compiled program from a state; return how it went."""
    endless = bool(np.isinf(program.length_s[:, 0]).all())
    # What goes from course to course is interpreted where there are few: compiled, the kernel of a course would be
    # compiled again inside it.
    few = endless and len(program.segments) <= _FEW_COURSES
    run_program = drive.run_program.py_func if few else drive.run_program  # type: ignore[attr-defined]
    status: int = run_program(
        by_reference(cell),
        program,
        None if endless else control,
        # Of arrays that may not be written a kernel is compiled anew.
        np.require(supply.time_s, np.float64, ["C", "W"]),
        np.require(supply.power_w, np.float64, ["C", "W"]),
        by_reference(state),
        book,
        by_reference(clock),
        None if endless else by_reference(new_stride()),
        None if endless else by_reference(new_clock(math.inf)),
        None if endless else _scratch(),
        ambient_k,
        float(engine.tolerance),
        float(engine.maximum_step_s),
        int(engine.maximum_steps),
        1 if endless else None,
    )
    return status


_FEW_COURSES = 100


def kernels_of(tasks: Sequence[Task]) -> set[str]:
    """Return what of the engine some charges need and nobody has compiled yet: `endless`, `periods`, or both.

    A sheet whose segments all last until something ends them needs no periods, which take more than half the time.
    """
    needed = {"endless" if _is_endless(task.mode) and len(tasks) < FEW else "periods" for task in tasks}
    kernels: dict[str, Any] = {"endless": run_endless, "periods": drive.run_program}
    return {kind for kind in needed if not kernels[kind]._cache._cache_file._load_index()}


def _is_endless(mode: Mode) -> bool:
    waveforms = [phase.waveform for phase in mode.phases.values()]
    return not any(waveform.periodic or isinstance(waveform, Sampled) for waveform in waveforms)


def _scratch() -> Book:
    """Return a book for the sums of single periods."""
    return new_book(0, 0, 0, np.zeros((0, 3)), np.zeros((0, 2)))


_WARM_UP_BATTERY = Battery(
    name="warm_up",
    title="Warm-up",
    cells_in_series=1,
    capacity_ah=1.0,
    open_circuit_voltage_v=2.0,
    series_resistance_ohm=0.01,
    pairs={"one": Pair(resistance_ohm=0.01, time_constant_s=1.0)},
    side_reaction=SideReaction(current_a=1e-6, reference_voltage_v=2.0, voltage_scale_v=0.1),
    thermal=Thermal(heat_capacity_j_k=100.0, resistance_k_w=1.0),
)
_WARM_UP_MODES = [
    Mode.model_validate({"title": "Warm-up", "phases": {"charge": waveform}, "stop": {"elapsed_s": 0.1}})
    for waveform in (
        {"constant_current": {"current_a": 1.0}},
        {"pulse": {"charge_a": 1.0, "charge_share": 0.5, "frequency_hz": 50.0}},
    )
]


def warm_up() -> list[str]:
    """Compile every kernel by a fraction of a second of a charge; return their names."""
    settings = ChargeSettings(initial_soc=0.5, ambient_c=25.0)
    tasks = [Task(_WARM_UP_BATTERY, mode, BENCH, settings, EngineSettings()) for mode in _WARM_UP_MODES]
    for charge in (*(simulate(*task) for task in tasks), *simulate_many(tasks[:1] * FEW)):
        assert charge.energy
    return [kernel.__name__ for kernel in (drive.run_program, run_lot, run_periods, enthalpy, value_and_slope)]
