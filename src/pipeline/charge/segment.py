"""Advance within one segment: pick the control, take a step, and stop short of whatever happens inside it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import REFERENCE_K, Cell
from pipeline.charge.energy import finish
from pipeline.charge.moment import place_start, solve_start
from pipeline.charge.state import (
    BLOCKED,
    CURRENT_CONTROL,
    DEPTH,
    MAIN,
    POWER_CONTROL,
    RELAXATIONS,
    START,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Demand,
    Run,
    T,
    X,
    lift_at,
    put,
    recall,
    remember,
)
from pipeline.charge.step import crossing, integrate, slot_of, step_error
from pipeline.charge.watching import watched_guard
from pipeline.jit import inlined, kernel

# What can happen inside a step. The first seven follow the order of the limits of a phase, the next those of a stop.
ELAPSED, SOC, VOLTAGE, CURRENT, WARM, DROP, RATE = range(7)
LIMITS = 7
EDGE = 14
TO_CURRENT, TO_VOLTAGE, TO_POWER, TO_BYPASS, TO_PAIR, TO_BLOCKED, TO_RELEASED, TO_CLAMP = range(15, 23)
NOTHING, FAILED = -1, -2

# Places in a row of limits: the edge of a stage, whether drop and rate are watched at all, then these two of the
# phase and of the stop. A phase without them pays one comparison.
STAGE_EDGE, WATCHED, FIRST_WATCHED, PLACES = 8, 9, 10, 14

_NEVER = 1e300
_CHATTER = 1e-9
ROUNDING = 1e-13
# Gap beyond zero at which a crossing is found.
_THERE = 1e-13
# Trials of a crossing that the model places, and how far beyond zero it aims.
_MODELLED, _BEYOND = 8, 1e-15
# Error below which the next step may be four times as long.
_EASY = 0.2**4


@inlined
def target_of(cell: Cell, demand: Demand, control: int) -> float:
    """Return what a control holds: current [A], voltage of a cell at 25 degC [V], or power of a cell [W]."""
    if control == CURRENT_CONTROL:
        return demand.current_a
    if control == BLOCKED:
        return 0.0
    if control == VOLTAGE_CONTROL:
        return demand.limit_v + demand.lift_v
    return float(demand.power_w / cell.cells)


@inlined
def solved_as(control: int) -> int:
    """Return the control that the circuit is solved under: a blocked charger is one with a current of nothing."""
    return CURRENT_CONTROL if control == BLOCKED else control


@kernel
def choose_control(cell: Cell, run: Run, demand: Demand) -> bool:
    """Pick the control that gives the least current and solve the start in it; False where the circuit fails.

    A voltage that would have to be held by drawing from the battery blocks the charger instead.
    """
    state, at = run.state, run.at
    run.control = CURRENT_CONTROL
    if cell.acceptance == 1:
        state[RELAXATIONS + cell.pairs] = max(0.0, state[RELAXATIONS + cell.pairs])
    place_start(cell, run)
    if not solve_start(cell, run, CURRENT_CONTROL, demand.current_a, demand.current_a):
        return False
    if demand.charging:
        limit_v = demand.limit_v + lift_at(demand, at[T, START])
        if at[TERMINAL_V, START] > limit_v:
            run.control = VOLTAGE_CONTROL
            if not solve_start(cell, run, VOLTAGE_CONTROL, limit_v, at[MAIN, START]):
                return False
            if at[TOTAL, START] < 0.0:
                run.control = BLOCKED
                if not solve_start(cell, run, CURRENT_CONTROL, 0.0, at[MAIN, START]):
                    return False
        if cell.cells * at[TERMINAL_V, START] * at[TOTAL, START] > demand.power_w:
            run.control = POWER_CONTROL
            if not solve_start(cell, run, POWER_CONTROL, demand.power_w / cell.cells, at[MAIN, START]):
                return False
    run.guess_a = at[MAIN, START]
    _choose_bypass(cell, run)
    return True


@inlined
def _choose_bypass(cell: Cell, run: Run) -> None:
    discharged = cell.acceptance == 1 and run.state[RELAXATIONS + cell.pairs] <= 0.0
    run.bypassed = 1 if discharged and run.at[MAIN, START] <= 0.0 else 0


@inlined
def continue_moment(cell: Cell, run: Run, demand: Demand) -> bool:
    """Solve the start of the next step under the control of the last one; False where the circuit fails."""
    # The step's own end is the better guess: where next to nothing is accepted, the start's balance is all rounding.
    run.guess_a = run.at[MAIN, 2]
    place_start(cell, run)
    target = target_of(cell, demand, run.control)
    if run.control == VOLTAGE_CONTROL:
        target += demand.lift_v_k * (run.at[T, START] - REFERENCE_K)
    return solve_start(cell, run, solved_as(run.control), target, run.guess_a)


@inlined
def guard_at(cell: Cell, run: Run, demand: Demand, limits: NDArray[np.float64], j: int) -> tuple[float, int]:
    """Return how far moment j is from the nearest thing that may happen, and what that is; negative beyond it.

    Arguments
    ---------
    limits : SOC as 1 - SOC, voltage, current, temperature of the phase, the same of the stop, then the stage's edge.
        What is watched beside these is not looked at here.
    """
    at, control = run.at, run.control
    total, terminal, lift_v = at[TOTAL, j], at[TERMINAL_V, j], lift_at(demand, at[T, j])
    least, what = _NEVER, NOTHING
    held = control in (VOLTAGE_CONTROL, BLOCKED)
    for of in range(2):
        base = 4 * of
        gap = at[X, j] - limits[base]
        if gap < least:
            least, what = gap, LIMITS * of + SOC
        gap = limits[base + 1] * (1.0 - ROUNDING) + lift_v - terminal
        if gap < least:
            least, what = gap, LIMITS * of + VOLTAGE
        if held and total - limits[base + 2] < least:
            least, what = total - limits[base + 2], LIMITS * of + CURRENT
        gap = limits[base + 3] - at[T, j]
        if gap < least:
            least, what = gap, LIMITS * of + WARM
    if at[X, j] - limits[STAGE_EDGE] < least:
        least, what = at[X, j] - limits[STAGE_EDGE], EDGE
    if demand.charging:
        if control == BLOCKED:
            gap = terminal - lift_v - demand.limit_v * (1.0 - _CHATTER)
            if gap < least:
                least, what = gap, TO_RELEASED
        elif control == VOLTAGE_CONTROL and total < least:
            least, what = total, TO_BLOCKED
        if control != CURRENT_CONTROL:
            gap = demand.current_a * (1.0 + _CHATTER) - total
            if gap < least:
                least, what = gap, TO_CURRENT
        if control != VOLTAGE_CONTROL and control != BLOCKED:
            gap = demand.limit_v * (1.0 + _CHATTER) + lift_v - terminal
            if gap < least:
                least, what = gap, TO_VOLTAGE
        if control != POWER_CONTROL:
            gap = demand.power_w * (1.0 + _CHATTER) - cell.cells * terminal * total
            if gap < least:
                least, what = gap, TO_POWER
    gap = min(at[T, j] - demand.lowest_k, demand.highest_k - at[T, j])
    if gap < least:
        least, what = gap, TO_CLAMP
    if cell.acceptance == 1:
        if run.bypassed == 1:
            if -at[MAIN, j] < least:
                least, what = -at[MAIN, j], TO_PAIR
        elif run.value[cell.pairs, j] < least:
            least, what = run.value[cell.pairs, j], TO_BYPASS
    return least, what


@inlined
def clear_at_start(run: Run, demand: Demand, limits: NDArray[np.float64]) -> bool:
    """Tell whether nothing that ends a phase holds at the start: one look in place of twelve."""
    x, v, t = run.at[X, START], run.at[TERMINAL_V, START], run.at[T, START]
    return bool(
        run.control == CURRENT_CONTROL
        and limits[WATCHED] == 0.0
        and v < min(limits[1], limits[5]) * (1.0 - ROUNDING) + lift_at(demand, t)
        and x > max(limits[0], max(limits[4], limits[STAGE_EDGE]))
        and t < min(limits[3], limits[7])
    )


@inlined
def clear(cell: Cell, run: Run, demand: Demand, limits: NDArray[np.float64]) -> bool:
    """Tell whether a step under current control keeps clear of every guard: one look in place of three times twelve."""
    if run.control != CURRENT_CONTROL or run.bypassed == 1 or limits[WATCHED] > 0.0:
        return False
    x, v, t, value = run.at[X], run.at[TERMINAL_V], run.at[T], run.value[cell.pairs]
    highest_v = max(v[0], max(v[1], v[2]))
    coldest, warmest = min(t[0], min(t[1], t[2])), max(t[0], max(t[1], t[2]))
    lift_v = min(lift_at(demand, coldest), lift_at(demand, warmest))
    allowed_v = min(limits[1], limits[5]) * (1.0 - ROUNDING)
    if demand.charging:
        allowed_v = min(allowed_v, demand.limit_v)
        if cell.cells * highest_v * demand.current_a > demand.power_w:
            return False
    return bool(
        highest_v <= allowed_v + lift_v
        and min(x[0], min(x[1], x[2])) >= max(limits[0], max(limits[4], limits[STAGE_EDGE]))
        and warmest <= min(min(limits[3], limits[7]), demand.highest_k)
        and coldest >= demand.lowest_k
        and (cell.acceptance == 0 or min(value[0], min(value[1], value[2])) >= 0.0)
    )


@inlined
def _fourth_root(value: float) -> float:
    return math.sqrt(math.sqrt(value))


@inlined
def guard(cell: Cell, run: Run, demand: Demand, limits: NDArray[np.float64]) -> tuple[float, int]:
    """Return the nearest guard over the nodes of the step just taken; that of each node goes to the run's row."""
    least, what = guard_at(cell, run, demand, limits, 2)
    run.row[2] = least
    for j in range(2):
        gap, kind = guard_at(cell, run, demand, limits, j)
        run.row[j] = gap
        if gap < least:
            least, what = gap, kind
    if limits[WATCHED] > 0.0:
        for j in range(3):
            gap, kind = watched_guard_at(cell, run, demand.charging, limits, j)
            run.row[j] = min(run.row[j], gap)
            if gap < least:
                least, what = gap, kind
    return least, what


@kernel
def guard_at_start(cell: Cell, run: Run, demand: Demand, limits: NDArray[np.float64]) -> tuple[float, int]:
    """Return the nearest guard at the start of a step."""
    least, what = guard_at(cell, run, demand, limits, START)
    if limits[WATCHED] > 0.0:
        gap, kind = watched_guard_at(cell, run, demand.charging, limits, START)
        if gap < least:
            least, what = gap, kind
    return least, what


@kernel
def watched_guard_at(cell: Cell, run: Run, charging: bool, limits: NDArray[np.float64], j: int) -> tuple[float, int]:
    """Return how far moment j is from the nearest stop that is watched for, of the phase and of the charge."""
    least, what = _NEVER, NOTHING
    for of in range(2):
        drop, rate = limits[FIRST_WATCHED + 2 * of], limits[FIRST_WATCHED + 2 * of + 1]
        gap, falls = watched_guard(cell, run, charging, drop, rate, j)
        if gap < least:
            least, what = gap, LIMITS * of + (DROP if falls else RATE)
    return least, what


@inlined
def try_step(cell: Cell, run: Run, demand: Demand, ambient_k: float, length_s: float) -> bool:
    """Integrate one step length from the state; `run` holds the result."""
    slot = slot_of(cell, run, length_s)
    run.slot = slot
    run.steps += 1
    target = target_of(cell, demand, run.control)
    return integrate(cell, run, slot, solved_as(run.control), target, run.bypassed == 1, ambient_k)


@inlined
def set_guess(cell: Cell, run: Run, length_s: float) -> None:
    """Guess that nothing changes over the step, nor that more is charged than there is room for."""
    main, t = run.at[MAIN], run.at[T]
    guess = min(run.guess_a, 0.5 * run.state[DEPTH] * cell.charge_as / length_s)
    put(main, guess, guess, guess, main[START])
    put(t, t[START], t[START], t[START], t[START])


@kernel
def locate(
    cell: Cell, run: Run, demand: Demand, limits: NDArray[np.float64], ambient_k: float, length_s: float
) -> tuple[float, int]:
    """Find where the nearest guard of an overlong step crosses zero; return the length that reaches it, and what it is.

    By a model of the guard over the step; where that does not lead there, by regula falsi (Illinois) on the step
    length, and by bisection of the ratio where the secant does not close in. Every trial is integrated from the step's
    start; the step found is left in `run`.
    """
    low, high = 0.0, length_s
    above, _ = guard_at_start(cell, run, demand, limits)
    at_start, last_s, last, beyond = above, length_s, 0.0, _BEYOND
    above = max(above, 1e-300)
    below, what = guard(cell, run, demand, limits)
    trial, side = length_s, 0
    for attempt in range(200):
        if below >= 0.0 or (high - low <= 1e-12 * (1e-3 + high) and attempt > 0):
            break
        wish = -1.0
        if attempt < _MODELLED:
            # Rounding may leave a trial on this side.
            beyond = min(8.0 * beyond, 5e-14) if 0.0 <= run.row[2] < _THERE else _BEYOND
            wish = trial * crossing(run.row, at_start, last_s / trial, last, beyond)
            last_s, last = trial, run.row[2]
        if low < wish < high:
            trial = wish
        else:
            share = above / (above - below)
            if attempt % 4 == 3:
                share = 0.5 if low > 0.01 * high else 0.03
            # A little off both ends, so that a root found from one side is enclosed by the next trial.
            trial = low + (high - low) * min(max(share, 1e-4), 1.0 - 1e-4)
        set_guess(cell, run, trial)
        if not try_step(cell, run, demand, ambient_k, trial):
            return high, FAILED
        gap, kind = guard(cell, run, demand, limits)
        if gap < 0.0:
            high, below, what = trial, gap, kind
            above *= 0.5 if side < 0 else 1.0
            side = -1
            if gap > -_THERE:
                return high, what
        else:
            low, above = trial, gap
            below *= 0.5 if side > 0 else 1.0
            side = 1
    if trial != high:
        set_guess(cell, run, high)
        if not try_step(cell, run, demand, ambient_k, high):
            return high, FAILED
        _, what = guard(cell, run, demand, limits)
    return high, what


@kernel
def advance(
    cell: Cell,
    run: Run,
    demand: Demand,
    limits: NDArray[np.float64],
    ambient_k: float,
    longest_s: float,
    proposal_s: float,
    tolerance: float,
) -> tuple[float, int, float]:
    """Take one accepted step of at most `longest_s`; the start column of `run` must hold the state.

    Returns
    -------
    length [s], what happened at its end (`NOTHING`, an event or `FAILED`), factor for the next proposal.
    """
    length_s = min(longest_s, proposal_s)
    for _ in range(2000):
        set_guess(cell, run, length_s)
        recall(run, length_s)
        fine = try_step(cell, run, demand, ambient_k, length_s)
        error = step_error(cell, run, length_s, run.bypassed == 1) / tolerance if fine else 1e8
        if not error < 1.0:
            length_s *= max(0.1, 0.8 / _fourth_root(error)) if math.isfinite(error) else 0.1
            if length_s < 1e-200:
                return 0.0, FAILED, 1.0
            continue
        gap, what = 0.0, NOTHING
        taken_s, factor = length_s, 1.0
        if not clear(cell, run, demand, limits):
            gap, what = guard(cell, run, demand, limits)
        if gap >= 0.0:
            remember(run, length_s)
            what, factor = NOTHING, 4.0 if error < _EASY else 0.8 / _fourth_root(error)
        else:
            taken_s, what = locate(cell, run, demand, limits, ambient_k, length_s)
            if what == FAILED:
                length_s *= 0.25
                continue
        finish(cell, run, run.slot, run.bypassed == 1, ambient_k)
        return taken_s, what, factor
    return 0.0, FAILED, 1.0


@inlined
def commit(run: Run) -> None:
    """Make the end of the step the state."""
    for n in range(len(run.state)):
        run.state[n] = run.end[n]
