"""The arrays that a run writes into, with room for what it may write; what is said where it could not go on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import MOST_RELAXATIONS, ZERO_CELSIUS_K
from pipeline.charge import drive
from pipeline.charge.program import Program
from pipeline.charge.record_keeping import PHASE_COLUMNS, SAMPLE_COLUMNS, SUMS, WAVEFORM_COLUMNS, Book
from pipeline.charge.records import ChargeSettings, EngineSettings
from pipeline.charge.state import DEPTH, PAIR_HEAT, TEMPERATURE
from pipeline.errors import EngineError

Array = NDArray[np.float64]
GAINS = PAIR_HEAT + MOST_RELAXATIONS


def new_book(samples: int, phases: int, points: int, marks: Array, windows: Array) -> Book:
    """Return an empty book with room for so many rows."""
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
        gains=np.zeros(GAINS),
        recent_gains=np.zeros(GAINS),
        peak_k=np.zeros(1),
    )


def book_for(program: Program, settings: ChargeSettings) -> Book:
    """Return an empty book for a charge."""
    marks, windows = marks_of(settings), windows_of(settings)
    rows = rows_of(program.stop_elapsed_s, settings.sample_interval_s)
    return new_book(rows, len(program.segments), points_of(program, windows), marks, windows)


def marks_of(settings: ChargeSettings) -> Array:
    """Return the marks of SOC as 1 - SOC, falling; time and temperature, not yet known, beside them, shape (m, 3)."""
    marks = np.full((len(settings.soc_marks), 3), np.nan)
    marks[:, 0] = 1.0 - np.sort(np.array(settings.soc_marks, dtype=np.float64))
    return marks


def windows_of(settings: ChargeSettings) -> Array:
    """Return start and end of each window [s], shape (w, 2)."""
    spans = [(window.start_s, window.start_s + window.length_s) for window in settings.windows]
    return np.array(spans, dtype=np.float64).reshape(-1, 2)


def rows_of(stop_elapsed_s: float, sample_interval_s: float) -> int:
    """Return room for the samples of a charge."""
    return math.ceil(stop_elapsed_s / sample_interval_s) + 3


def points_of(program: Program, windows: Array) -> int:
    """Return room for the windows: a grid of each segment, and both ends of each of its steps."""
    if not windows.size:
        return 0
    finite = program.length_s[np.isfinite(program.length_s) & (program.length_s > 0)]
    shortest = float(finite.min()) if finite.size else math.inf
    spans = windows[:, 1] - windows[:, 0]
    return int(sum(2000 + 80 * (span / min(shortest, span) + 2) + 500 for span in spans))


def failure(status: int, end_s: float, steps: int, state: Array, engine: EngineSettings) -> EngineError:
    """Return what is to be raised of a run that did not come to its end."""
    failed = status == drive.CIRCUIT_FAILED
    problem = "no solution of the circuit" if failed else "the steps are used up"
    remedy = "" if failed else f"; engine.maximum_steps is {engine.maximum_steps}, give more or a shorter stop"
    return EngineError(
        f"{problem} at {end_s:.9g} s after {steps} steps: SOC {1.0 - state[DEPTH]:.9g}, "
        f"temperature {state[TEMPERATURE] - ZERO_CELSIUS_K:.6g} degC{remedy}"
    )
