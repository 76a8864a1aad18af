"""The kernel behind `switched`: from sample to sample by exact maps, with the instants of switches between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.topologies import BLOCKED, DIODE, DISCHARGE, INDUCTOR, LOW, ON, RETURN, SIZE
from pipeline.jit import inlined, jit, kernel

Array = NDArray[np.float64]

PERIOD_COLUMNS = (
    "duty",
    "inductor_mean_a",
    "battery_mean_a",
    "voltage_mean_v",
    "battery_min_a",
    "battery_max_a",
    "voltage_min_v",
    "voltage_max_v",
    "source_mean_a",
)
"""Of each switching period; means are exact, extremes are those of the samples."""

_TERMS = 10
_NEWTON_STEPS = 50


@inlined
def _apply(maps: Array, place: int, tick: int, state: Array, out: Array) -> None:
    for row in range(SIZE):
        total = 0.0
        for column in range(SIZE):
            total += maps[place, tick, row, column] * state[column]
        out[row] = total


@inlined
def advance(
    generators: Array, steps: Array, sums: Array, tick_s: float, place: int, length_s: float, state: Array, work: Array
) -> None:
    """Carry z over an interval of any length up to a sample.

    Arguments
    ---------
    place : the circuit.
    length_s : length of the interval [s].
    state : z at its start, shape (4,).
    work : row 0 becomes z at its end, row 1 the integral of z; the others are room, shape (4, 4).
    """
    tick = min(int(length_s / tick_s), steps.shape[1] - 1)
    rest = length_s - tick * tick_s
    _apply(steps, place, tick, state, work[0])
    _apply(sums, place, tick, state, work[1])
    if rest <= 0.0:
        return
    for row in range(SIZE):
        work[2, row] = work[0, row]
        work[1, row] += rest * work[0, row]
    for order in range(1, _TERMS + 1):
        share = rest / order
        for row in range(SIZE):
            total = 0.0
            for column in range(SIZE):
                total += generators[place, row, column] * work[2, column]
            work[3, row] = total * share
        following = rest / (order + 1)
        for row in range(SIZE):
            work[2, row] = work[3, row]
            work[0, row] += work[3, row]
            work[1, row] += following * work[3, row]


@kernel
def zero_current_s(
    generators: Array, steps: Array, sums: Array, tick_s: float, place: int, length_s: float, state: Array, work: Array
) -> float:
    """Return when the inductor current passes zero within an interval over which it changes its sign [s].

    Newton's method on the exact current, kept between the ends of what is left of the interval.
    """
    low, high = 0.0, length_s
    first, last = state[INDUCTOR], work[0, INDUCTOR]
    time = length_s * first / (first - last)
    for _ in range(_NEWTON_STEPS):
        advance(generators, steps, sums, tick_s, place, time, state, work)
        current, slope = work[0, INDUCTOR], 0.0
        for column in range(SIZE):
            slope += generators[place, INDUCTOR, column] * work[0, column]
        if current * first > 0.0:
            low = time
        else:
            high = time
        following = time - current / slope if slope != 0.0 else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - time) <= 1e-15 * length_s:
            break
        time = following
    return float(time)


@inlined
def _control(asked_a: float, per_a: float, integral_per_a: float, most: float, bus_v: float, memory: Array) -> float:
    """Return the duty of a period, and move the integral part unless that drives the duty further past its limit."""
    error = asked_a - memory[1]
    moved = memory[0] + integral_per_a * error
    wanted = memory[2] / bus_v + per_a * error + moved
    duty = min(max(wanted, 0.0), most)
    if duty == wanted or (duty - wanted) * error > 0.0:
        memory[0] = moved
    return float(duty)


@inlined
def _after(current_a: float, switches: bool, synchronous: bool, idle: int) -> int:
    """Return the circuit once the switch is off."""
    if switches and synchronous:
        return LOW
    if current_a > 0.0:
        return DIODE
    return RETURN if current_a < 0.0 else idle


@inlined
def _read(outputs: Array, place: int, which: int, state: Array) -> float:
    total = 0.0
    for column in range(SIZE):
        total += outputs[place, which, column] * state[column]
    return float(total)


@inlined
def _fold(outputs: Array, place: int, gathered: Array, totals: Array) -> None:
    """Add the integral of z in one circuit to those of the outputs, and begin a new one."""
    totals[0] += gathered[INDUCTOR]
    totals[1] += _read(outputs, place, 0, gathered)
    totals[2] += _read(outputs, place, 1, gathered)
    if place in (ON, RETURN):
        totals[3] += gathered[INDUCTOR]
    for row in range(SIZE):
        gathered[row] = 0.0


@jit
def run_periods(
    generators: Array,
    steps: Array,
    sums: Array,
    outputs: Array,
    tick_s: float,
    sample_s: float,
    samples: int,
    proportional_per_a: float,
    integral_per_a: float,
    most_duty: float,
    bus_voltage_v: float,
    synchronous: bool,
    fixed_duty: float,
    reference: Array,
    state: Array,
    memory: Array,
    points: Array,
    periods: Array,
) -> None:
    """Run the converter, a switching period for each reference; arguments as in `switched.follow`."""
    ticks = steps.shape[1] - 1
    period_s = samples * sample_s
    work, gathered, totals = np.empty((4, SIZE)), np.zeros(SIZE), np.zeros(4)
    place = BLOCKED
    for number in range(len(reference)):
        asked, duty = reference[number], max(fixed_duty, 0.0)
        switches = fixed_duty >= 0.0 or asked > 0.0
        if switches and fixed_duty < 0.0:
            duty = _control(asked, proportional_per_a, integral_per_a, most_duty, bus_voltage_v, memory)
        idle = DISCHARGE if asked < 0.0 else BLOCKED
        on_s = duty * period_s
        place = ON if on_s > 0.0 else _after(state[INDUCTOR], switches, synchronous, idle)
        totals[:] = 0.0
        low_a, high_a, low_v, high_v = np.inf, -np.inf, np.inf, -np.inf
        for sample in range(samples):
            current, voltage = _read(outputs, place, 0, state), _read(outputs, place, 1, state)
            here = number * samples + sample
            points[0, here], points[1, here], points[2, here] = state[INDUCTOR], current, voltage
            low_a, high_a = min(low_a, current), max(high_a, current)
            low_v, high_v = min(low_v, voltage), max(high_v, voltage)
            begin, goal = sample * sample_s, (sample + 1) * sample_s
            while begin < goal:
                turns_off = place == ON and on_s < goal
                length = max(on_s - begin, 0.0) if turns_off else goal - begin
                if not turns_off and begin == sample * sample_s:
                    _apply(steps, place, ticks, state, work[0])
                    _apply(sums, place, ticks, state, work[1])
                else:
                    advance(generators, steps, sums, tick_s, place, length, state, work)
                empty = (place == DIODE and work[0, INDUCTOR] < 0.0) or (place == RETURN and work[0, INDUCTOR] > 0.0)
                if empty:
                    length = zero_current_s(generators, steps, sums, tick_s, place, length, state, work)
                    work[0, INDUCTOR] = 0.0
                for row in range(SIZE):
                    state[row] = work[0, row]
                    gathered[row] += work[1, row]
                if not (turns_off or empty):
                    break
                begin += length
                _fold(outputs, place, gathered, totals)
                place = idle if empty else _after(state[INDUCTOR], switches, synchronous, idle)
        _fold(outputs, place, gathered, totals)
        memory[1], memory[2] = totals[0] / period_s, totals[2] / period_s
        periods[0, number] = duty
        for column in range(3):
            periods[1 + column, number] = totals[column] / period_s
        periods[4, number], periods[5, number], periods[6, number], periods[7, number] = low_a, high_a, low_v, high_v
        periods[8, number] = totals[3] / period_s
    end = len(reference) * samples
    points[0, end] = state[INDUCTOR]
    points[1, end], points[2, end] = _read(outputs, place, 0, state), _read(outputs, place, 1, state)
