"""Charge a battery by a mode from a supply: records in, columns out; one charge, or many at once."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import MOST_RELAXATIONS, ZERO_CELSIUS_K, Cell, compile_cell, enthalpy
from pipeline.cell.curves import value_and_slope
from pipeline.cell.records import Battery, Pair, SideReaction, Thermal
from pipeline.charge import drive
from pipeline.charge.checks import check
from pipeline.charge.controller import Control, compile_control
from pipeline.charge.energy import balance
from pipeline.charge.outcome import Columns, Outcome, missed, phases, reason, trace, waveform
from pipeline.charge.period import Clock, new_clock, run_periods
from pipeline.charge.program import Program, compile_program
from pipeline.charge.protocol import resolve
from pipeline.charge.record_keeping import PHASE_COLUMNS, SAMPLE_COLUMNS, SUMS, WAVEFORM_COLUMNS, Book
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.state import DEPTH, HYSTERESIS, PAIR_HEAT, TEMPERATURE, Run, new_run
from pipeline.charge.stride import new_stride
from pipeline.charge.summary import Quantity, summarise
from pipeline.errors import EngineError
from pipeline.jit import by_reference


class Supply(NamedTuple):
    """Power available at the battery's terminals, constant from each time to the next; inf is a bench supply.

    time_s : (m,), rising from 0; power_w : (m,).
    drawn_per_w, side_w : what the source gives for a watt at the terminals [1], and for side loads [W], (m,) each;
        where not given, nothing is lost on the way and nothing hangs there.
    """

    time_s: NDArray[np.float64]
    power_w: NDArray[np.float64]
    drawn_per_w: NDArray[np.float64] | None = None
    side_w: NDArray[np.float64] | None = None

    def drawn_j(self, time_s: NDArray[np.float64], put_in_j: NDArray[np.float64]) -> float:
        """Return the energy drawn at the source over a charge [J].

        Arguments
        ---------
        time_s, put_in_j : ends of intervals from 0 on, and the energy put in up to each, shape (n,).
        """
        ends, edges = np.append(0.0, time_s), np.append(self.time_s[1:], np.inf)
        put_in = np.diff(np.append(0.0, put_in_j))
        rows = np.searchsorted(self.time_s, 0.5 * (ends[1:] + ends[:-1]), side="right") - 1
        per_w = np.ones(1) if self.drawn_per_w is None else self.drawn_per_w[rows]
        side_j = 0.0
        if self.side_w is not None:
            side_j = float(np.sum(self.side_w * np.maximum(0.0, np.minimum(edges, ends[-1]) - self.time_s)))
        return float(np.sum(put_in * per_w)) + side_j


BENCH = Supply(np.zeros(1), np.full(1, np.inf))


@dataclass(frozen=True)
class Charge:
    """What came of a charge: columns of the four tables, and the summary."""

    trace: Columns
    waveform: Columns
    phases: Columns
    energy: Columns
    summary: list[Quantity]


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
    energy = balance(outcome.cell, outcome.book.gains, outcome.start, outcome.run["state"], tuple(battery.pairs))
    samples = outcome.book.samples[: outcome.book.filled[0]]
    drawn_j = supply.drawn_j(samples[:, 0], samples[:, 6] * 3600.0)
    return Charge(
        trace=trace(outcome, settings.ambient_c),
        waveform=waveform(outcome),
        phases=phases(outcome),
        energy=energy,
        summary=summarise(outcome, settings, energy, drawn_j, reason(outcome, -1), missed(outcome)),
    )


class Task(NamedTuple):
    """One charge: the arguments of `simulate`."""

    battery: Battery
    mode: Mode
    supply: Supply
    settings: ChargeSettings
    engine: EngineSettings


def simulate_many(tasks: Iterable[Task], threads: int | None = None) -> list[Charge]:
    """Charge many batteries at once; each charge is, bit for bit, what `simulate` makes of it.

    The kernels let go of Python's lock, so threads run as many of them as there are cores. Whichever thread is free
    takes the next charge: a population is seldom of equal lengths, and its arrays never need to be of one shape.

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
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    with ThreadPoolExecutor(max_workers=threads or count) as pool:
        return list(pool.map(lambda task: simulate(*task), tasks))


def run(battery: Battery, mode: Mode, supply: Supply, settings: ChargeSettings, engine: EngineSettings) -> Outcome:
    """Run the engine and return its arrays; arguments and errors are those of `simulate`."""
    check(battery, mode, settings)
    cell = compile_cell(battery)
    protocol = resolve(mode, battery.capacity_in_use_ah, battery.fills, battery.cells)
    program = compile_program(protocol, battery.cells_in_series, engine.driver, battery.cells_in_unit)
    state = resting_run(cell, settings.initial_soc, settings.start_c + ZERO_CELSIUS_K)
    start = state["state"].copy()
    book = _book(program, settings, cell)
    book.peak_k[0] = start[TEMPERATURE]
    control = compile_control(protocol, battery.capacity_in_use_ah)
    clock = new_clock(float(settings.sample_interval_s))
    status = launch(cell, program, control, supply, state, book, clock, settings.ambient_c + ZERO_CELSIUS_K, engine)
    end_s = float(clock["time_s"])
    if status != drive.DONE:
        failed = status == drive.CIRCUIT_FAILED
        problem = "no solution of the circuit" if failed else "the steps are used up"
        remedy = "" if failed else f"; engine.maximum_steps is {engine.maximum_steps}, give more or a shorter stop"
        raise EngineError(
            f"{problem} at {end_s:.9g} s after {state['steps']} steps: SOC {1.0 - state['state'][DEPTH]:.9g}, "
            f"temperature {state['state'][TEMPERATURE] - ZERO_CELSIUS_K:.6g} degC{remedy}"
        )
    return Outcome(cell, protocol, state, book, start, end_s)


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
    return drive.run_program(
        by_reference(cell),
        program,
        control,
        np.ascontiguousarray(supply.time_s, dtype=np.float64),
        np.ascontiguousarray(supply.power_w, dtype=np.float64),
        by_reference(state),
        book,
        by_reference(clock),
        by_reference(new_stride()),
        by_reference(new_clock(math.inf)),
        _scratch(),
        ambient_k,
        float(engine.tolerance),
        float(engine.maximum_step_s),
        int(engine.maximum_steps),
    )


def _book(program: Program, settings: ChargeSettings, cell: Cell) -> Book:
    marks = np.full((len(settings.soc_marks), 3), np.nan)
    marks[:, 0] = 1.0 - np.sort(np.array(settings.soc_marks, dtype=np.float64))
    windows = np.array([(w.start_s, w.start_s + w.length_s) for w in settings.windows], dtype=np.float64).reshape(-1, 2)
    rows = math.ceil(program.stop_elapsed_s / settings.sample_interval_s) + 3
    return new_book(rows, len(program.segments), _points(program, windows), marks, windows)


def _scratch() -> Book:
    """Return a book for the sums of single periods."""
    return new_book(0, 0, 0, np.zeros((0, 3)), np.zeros((0, 2)))


def new_book(samples: int, phases: int, points: int, marks: NDArray[np.float64], windows: NDArray[np.float64]) -> Book:
    """Return an empty book with room for so many rows."""
    gains = PAIR_HEAT + MOST_RELAXATIONS
    return Book(
        samples=np.zeros((samples, SAMPLE_COLUMNS)),
        phases=np.zeros((phases, PHASE_COLUMNS)),
        waveform=np.zeros((points, WAVEFORM_COLUMNS)),
        marks=marks,
        windows=windows,
        filled=np.zeros(4, dtype=np.int64),
        sums=np.zeros(SUMS),
        extremes=np.zeros(4),
        totals=np.zeros(SUMS),
        gains=np.zeros(gains),
        recent_gains=np.zeros(gains),
        peak_k=np.zeros(1),
    )


def _points(program: Program, windows: NDArray[np.float64]) -> int:
    """Return room for the windows: a grid of each segment, and both ends of each of its steps."""
    if not windows.size:
        return 0
    finite = program.length_s[np.isfinite(program.length_s) & (program.length_s > 0)]
    shortest = float(finite.min()) if finite.size else math.inf
    spans = windows[:, 1] - windows[:, 0]
    return int(sum(2000 + 80 * (span / min(shortest, span) + 2) + 500 for span in spans))


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
_WARM_UP_MODE = Mode.model_validate(
    {
        "title": "Warm-up",
        "phases": {"charge": {"constant_current": {"current_a": 1.0}}},
        "stop": {"elapsed_s": 0.1},
    }
)


def warm_up() -> list[str]:
    """Compile every kernel by a fraction of a second of a charge; return their names."""
    simulate(_WARM_UP_BATTERY, _WARM_UP_MODE, BENCH, ChargeSettings(initial_soc=0.5, ambient_c=25.0), EngineSettings())
    return [kernel.__name__ for kernel in (drive.run_program, run_periods, enthalpy, value_and_slope)]
