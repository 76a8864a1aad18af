"""What a run writes down while it goes: samples, marks, phases, windows at full resolution, sums."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ENTROPIC, OPEN_CIRCUIT, REFERENCE_K, Cell, hysteresis_at, series_ohm
from pipeline.cell.curves import value_and_slope
from pipeline.cell.relaxation import LAGRANGE, response
from pipeline.charge.moment import charge_transfer
from pipeline.charge.state import (
    BLOCKED,
    CHARGE,
    CURRENT_CONTROL,
    DEPTH,
    ELECTRICAL,
    HYSTERESIS,
    MAIN,
    PAIR_HEAT,
    POWER_CONTROL,
    RELAXATIONS,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE,
    SIDE_CHARGE,
    SIDE_HEAT,
    START,
    TEMPERATURE,
    TERMINAL_V,
    TO_AMBIENT,
    TOTAL,
    VOLTAGE_CONTROL,
    VOLTAGE_TIME,
    Run,
    T,
    put,
)
from pipeline.jit import inlined, kernel

# Sums since the last sample.
(
    SPAN_S,
    CHARGE_IN,
    CHARGE_OUT,
    ENERGY_IN,
    ENERGY_OUT,
    VOLTAGE_LIMITED_S,
    SUPPLY_LIMITED_S,
    CURRENT_LIMITED_S,
    SUMS,
) = range(9)
LOWEST_V, HIGHEST_V, LOWEST_A, HIGHEST_A = range(4)

SAMPLE_COLUMNS = 17
PHASE_COLUMNS = 9
WAVEFORM_COLUMNS = 6
POINTS_PER_SEGMENT = 24
# A stop at a mark ends the charge within this of it.
_ROUNDING = 1e-12
# Share of the capacity that a rest, which takes in rounding alone, stays below.
_AT_REST_PER_S = 1e-9
_PER_HOUR = 1.0 / 3600.0


class Book(NamedTuple):
    """Arrays a run writes into; `filled` counts rows of samples, phases, waveform, then marks reached."""

    samples: NDArray[np.float64]
    phases: NDArray[np.float64]
    waveform: NDArray[np.float64]
    marks: NDArray[np.float64]
    windows: NDArray[np.float64]
    filled: NDArray[np.int64]
    sums: NDArray[np.float64]
    extremes: NDArray[np.float64]
    totals: NDArray[np.float64]
    gains: NDArray[np.float64]
    recent_gains: NDArray[np.float64]
    peak_k: NDArray[np.float64]


@inlined
def add_step(cell: Cell, run: Run, book: Book, length_s: float) -> None:
    """Add an accepted step to the sums since the last sample."""
    gain, at, sums, extremes = run.gain, run.at, book.sums, book.extremes
    if run.control == BLOCKED:
        # What is left is rounding.
        gain[CHARGE] = gain[ELECTRICAL] = 0.0
    _add_charge(run, book, length_s)
    if run.control == VOLTAGE_CONTROL or run.control == BLOCKED:
        sums[VOLTAGE_LIMITED_S] += length_s
    elif run.control == POWER_CONTROL and run.supplied:
        sums[SUPPLY_LIMITED_S] += length_s
    elif gain[CHARGE] > _AT_REST_PER_S * cell.charge_as * length_s:
        sums[CURRENT_LIMITED_S] += length_s
    for n in range(PAIR_HEAT + cell.pairs + cell.acceptance):
        book.recent_gains[n] += gain[n]
    v, a, t = at[TERMINAL_V], at[TOTAL], at[T]
    lowest_a = min(min(a[0], a[1]), min(a[2], a[3]))
    # Where something limits a charging current, what lies below zero is the rounding of where it got there.
    lowest_a = lowest_a if run.control == CURRENT_CONTROL else max(lowest_a, 0.0)
    lowest_v, highest_v = min(min(v[0], v[1]), min(v[2], v[3])), max(max(v[0], v[1]), max(v[2], v[3]))
    widen(extremes, lowest_v, highest_v, lowest_a, max(max(a[0], a[1]), max(a[2], a[3])))
    book.peak_k[0] = max(book.peak_k[0], max(max(t[0], t[1]), max(t[2], t[3])))


@inlined
def widen(extremes: NDArray[np.float64], low_v: float, high_v: float, low_a: float, high_a: float) -> None:
    """Let extremes of voltage and current reach as far as these; all four written at once, whichever changes."""
    a, b, c, d = extremes[LOWEST_V], extremes[HIGHEST_V], extremes[LOWEST_A], extremes[HIGHEST_A]
    a, b, c, d = min(a, low_v), max(b, high_v), min(c, low_a), max(d, high_a)
    put(extremes, a, b, c, d)


@inlined
def add_plain(cell: Cell, run: Run, book: Book, current: float, length_s: float, start_v: float, end_v: float) -> None:
    """Add a segment crossed in closed form to the sums since the last sample."""
    gain, gains, extremes = run.gain, book.recent_gains, book.extremes
    _add_charge(run, book, length_s)
    if current > 0.0:
        book.sums[CURRENT_LIMITED_S] += length_s
    for n in (CHARGE, VOLTAGE_TIME, ELECTRICAL, SERIES_HEAT, REVERSIBLE_HEAT, TO_AMBIENT):
        gains[n] += gain[n]
    if cell.side == 1:
        gains[SIDE_CHARGE] += gain[SIDE_CHARGE]
        gains[SIDE_HEAT] += gain[SIDE_HEAT]
    for k in range(cell.pairs + cell.acceptance):
        gains[PAIR_HEAT + k] += gain[PAIR_HEAT + k]
    widen(extremes, min(start_v, end_v), max(start_v, end_v), current, current)
    book.peak_k[0] = max(book.peak_k[0], run.end[TEMPERATURE])


@inlined
def _add_charge(run: Run, book: Book, length_s: float) -> None:
    gain, sums = run.gain, book.sums
    if gain[CHARGE] >= 0.0:
        sums[CHARGE_IN] += gain[CHARGE]
        sums[ENERGY_IN] += gain[ELECTRICAL]
    else:
        sums[CHARGE_OUT] -= gain[CHARGE]
        sums[ENERGY_OUT] -= gain[ELECTRICAL]
    sums[SPAN_S] += length_s


@inlined
def passes_mark(book: Book, depth: float) -> bool:
    """Tell whether the next mark of SOC has been reached at this 1 - SOC."""
    return bool(book.filled[3] < len(book.marks) and depth <= book.marks[book.filled[3], 0] + _ROUNDING)


@inlined
def meets_window(book: Book, time_s: float, end_s: float) -> bool:
    """Tell whether a span of time touches a window."""
    for window in range(len(book.windows)):
        if time_s <= book.windows[window, 1] and end_s >= book.windows[window, 0]:
            return True
    return False


@inlined
def reset_extremes(book: Book) -> None:
    """Forget the extremes of the last interval."""
    book.extremes[LOWEST_V] = book.extremes[LOWEST_A] = math.inf
    book.extremes[HIGHEST_V] = book.extremes[HIGHEST_A] = -math.inf


@kernel
def take_sample(cell: Cell, run: Run, book: Book, time_s: float, phase: int) -> None:
    """Write a sample of the interval since the last one, if any time has passed, and start a new interval."""
    sums, totals = book.sums, book.totals
    span = sums[SPAN_S]
    if span <= 0.0:
        return
    for n in range(SUMS):
        totals[n] += sums[n]
    row, per_s = book.samples[book.filled[0]], 1.0 / span
    row[0] = time_s
    row[1] = book.recent_gains[VOLTAGE_TIME] * per_s
    row[2] = (sums[CHARGE_IN] - sums[CHARGE_OUT]) * per_s
    row[3] = phase + 1
    for n in range(4):
        row[4 + n] = totals[CHARGE_IN + n] * _PER_HOUR
    row[8] = run.state[TEMPERATURE]
    row[9] = 1.0 - run.state[DEPTH]
    row[10] = cell.cells * book.extremes[LOWEST_V]
    row[11] = cell.cells * book.extremes[HIGHEST_V]
    row[12] = book.extremes[LOWEST_A]
    row[13] = book.extremes[HIGHEST_A]
    row[14] = book.recent_gains[SIDE_CHARGE] * per_s
    row[15] = sums[SUPPLY_LIMITED_S] * per_s
    row[16] = sums[VOLTAGE_LIMITED_S] * per_s
    book.filled[0] += 1
    for n in range(len(book.gains)):
        book.gains[n] += book.recent_gains[n]
        book.recent_gains[n] = 0.0
    sums[:] = 0.0
    reset_extremes(book)


@kernel
def at_fraction(values: NDArray[np.float64], theta: float) -> float:
    """Return the quadratic through the three nodes at a fraction of the step."""
    total = 0.0
    for node in range(3):
        total += values[node] * (LAGRANGE[0, node] + theta * (LAGRANGE[1, node] + theta * LAGRANGE[2, node]))
    return total


@kernel
def depth_at(cell: Cell, run: Run, length_s: float, theta: float) -> float:
    """Return 1 - SOC at a fraction of the step just taken."""
    drawn, main = 0.0, run.at[MAIN]
    for node in range(3):
        basis = LAGRANGE[0, node] + theta * (LAGRANGE[1, node] / 2.0 + theta * LAGRANGE[2, node] / 3.0)
        drawn += theta * basis * main[node]
    return float(run.state[DEPTH] - length_s / cell.charge_as * drawn)


@kernel
def temperature_at(run: Run, theta: float) -> float:
    """Return the temperature at a fraction of the step: the cubic through its start and the nodes."""
    at, total = run.at, 0.0
    nodes = (0.0, 0.15505102572168219, 0.6449489742783178, 1.0)
    for i in range(4):
        basis = 1.0
        for j in range(4):
            if j != i:
                basis *= (theta - nodes[j]) / (nodes[i] - nodes[j])
        total += basis * (run.state[TEMPERATURE] if i == 0 else at[T, i - 1])
    return total


@kernel
def note_marks(cell: Cell, run: Run, book: Book, time_s: float, length_s: float) -> None:
    """Write time and temperature at each mark of SOC that the step just taken passes, by bisection of its cubic."""
    while passes_mark(book, run.end[DEPTH]):
        mark = book.marks[book.filled[3]]
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if depth_at(cell, run, length_s, middle) <= mark[0]:
                high = middle
            else:
                low = middle
        mark[1] = time_s + high * length_s
        mark[2] = temperature_at(run, high)
        book.filled[3] += 1


@kernel
def write_point(cell: Cell, run: Run, book: Book, window: int, time_s: float, length_s: float, theta: float) -> None:
    """Write one point of a window inside the step just taken."""
    if book.filled[2] >= len(book.waveform):
        return
    at = run.at
    x, temperature = depth_at(cell, run, length_s, theta), temperature_at(run, theta)
    if theta <= 0.0:
        current, voltage = at[TOTAL, START], at[TERMINAL_V, START]
    elif theta >= 1.0:
        current, voltage = at[TOTAL, 2], at[TERMINAL_V, 2]
    else:
        main = at_fraction(at[MAIN], theta)
        current = main + at_fraction(at[SIDE], theta)
        open_v, _ = value_and_slope(cell, OPEN_CIRCUIT, x)
        entropy, _ = value_and_slope(cell, ENTROPIC, x)
        ohm = series_ohm(cell, x, temperature)
        eta, _, _ = charge_transfer(cell, x, temperature, main)
        voltage = open_v + entropy * (temperature - REFERENCE_K) + ohm * current + eta
        if cell.hysteresis == 1:
            voltage += hysteresis_at(cell, run.state[HYSTERESIS], x - run.state[DEPTH])[0]
        for k in range(cell.pairs + cell.acceptance):
            w = run.row
            left = response(length_s / cell.tau_s[k], theta, run.phi, w)
            voltage += left * run.state[RELAXATIONS + k]
            for node in range(3):
                voltage += w[node] * run.forcing[k, node]
    row = book.waveform[book.filled[2]]
    row[0], row[1], row[2], row[3], row[4], row[5] = (
        window,
        time_s + theta * length_s,
        current,
        cell.cells * voltage,
        1.0 - x,
        temperature,
    )
    book.filled[2] += 1


@kernel
def write_windows(cell: Cell, run: Run, book: Book, time_s: float, length_s: float, segment_s: float) -> None:
    """Write the part of the step just taken that lies in a window, on a grid of the segment, ends included."""
    for window in range(len(book.windows)):
        first, last = book.windows[window, 0], book.windows[window, 1]
        begin, finish = max(time_s, first), min(time_s + length_s, last)
        if finish <= begin:
            continue
        spacing = min(segment_s / POINTS_PER_SEGMENT, (last - first) / (10 * POINTS_PER_SEGMENT))
        points = max(1, math.ceil((finish - begin) / spacing - 1e-9))
        for n in range(points + 1):
            when = begin + (finish - begin) * n / points
            theta = min(1.0, max(0.0, (when - time_s) / length_s))
            write_point(cell, run, book, window, time_s, length_s, theta)
