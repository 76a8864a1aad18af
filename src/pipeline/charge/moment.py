"""The circuit at one moment: a node of a step, or its start."""

from __future__ import annotations

import math

from pipeline.cell.circuit import (
    ENTROPIC,
    EXCHANGE,
    FIRST_PAIR,
    OPEN_CIRCUIT,
    REFERENCE_K,
    SERIES,
    THERMAL_V_PER_K,
    Cell,
    side_current,
)
from pipeline.cell.curves import factor_and_slope, value_and_slope
from pipeline.charge.state import (
    CURRENT_CONTROL,
    DEPTH,
    ENTROPY,
    ENTROPY_SLOPE,
    ETA,
    ETA_BY_DEPTH,
    ETA_SLOPE,
    HYSTERESIS,
    HYSTERESIS_V,
    MAIN,
    NODE_V,
    OHM,
    OHM_SLOPE,
    OPEN_SLOPE,
    POWER_CONTROL,
    RELAXATIONS,
    SIDE,
    SIDE_SLOPE,
    SLOW_V,
    START,
    TEMPERATURE,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Run,
    T,
    X,
)
from pipeline.jit import inlined, kernel

# Share of what is held that a residual may keep where rounding is all that is left of it.
_NOISE = 1e-12


@inlined
def circuit_at(cell: Cell, run: Run, j: int) -> None:
    """Evaluate at moment j everything that depends on SOC alone, and its slope with x; hysteresis as at the start."""
    at, slope = run.at, run.depth_slope
    x = at[X, j]
    open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, x)
    entropy, entropy_slope = value_and_slope(cell, ENTROPIC, x)
    warmer = at[T, j] - REFERENCE_K
    at[SLOW_V, j] = open_v + entropy * warmer + run.state[HYSTERESIS]
    at[ENTROPY, j] = entropy
    slope[OPEN_SLOPE, j], slope[ENTROPY_SLOPE, j] = open_slope + entropy_slope * warmer, entropy_slope
    at[OHM, j], slope[OHM_SLOPE, j] = value_and_slope(cell, SERIES, x)
    for k in range(cell.pairs):
        run.resistance[k, j], run.slope[k, j] = value_and_slope(cell, FIRST_PAIR + k, x)
        run.inverse[k, j] = 1.0 / run.resistance[k, j] if run.resistance[k, j] > 0.0 else 0.0
    if cell.acceptance == 1:
        k = cell.pairs
        reciprocal = 1.0 / x
        resistance = cell.acceptance_ohm * reciprocal
        run.inverse[k, j] = x / cell.acceptance_ohm
        run.resistance[k, j], run.slope[k, j] = resistance, -resistance * reciprocal
        run.bend[k] = 2.0 * resistance * reciprocal * reciprocal
    if cell.warming == 1:
        _warm(cell, run, j)


@kernel
def _warm(cell: Cell, run: Run, j: int) -> None:
    """Multiply the resistances at moment j by what its temperature makes of them: R(s) f(T)."""
    at, temperature_k = run.at, run.at[T, j]
    factor, _ = factor_and_slope(cell, 0, temperature_k)
    at[OHM, j] *= factor
    run.depth_slope[OHM_SLOPE, j] *= factor
    for k in range(cell.pairs + cell.acceptance):
        factor, run.warming[k, j] = factor_and_slope(cell, 1 + k, temperature_k)
        run.resistance[k, j] *= factor
        run.slope[k, j] *= factor
        run.inverse[k, j] /= factor


@inlined
def charge_transfer(cell: Cell, x: float, temperature_k: float, main_a: float) -> tuple[float, float, float]:
    """Return the overpotential (2RT/F) asinh(i / 2 i0) [V] and its slopes with current and with x."""
    if cell.transfer == 0:
        return 0.0, 0.0, 0.0
    exchange, exchange_slope = value_and_slope(cell, EXCHANGE, x)
    scale = 2.0 * THERMAL_V_PER_K * temperature_k
    with_current = scale / math.hypot(main_a, 2.0 * exchange)
    overpotential = scale * math.asinh(main_a / (2.0 * exchange))
    return overpotential, with_current, -with_current * main_a / exchange * exchange_slope


@inlined
def finish_moment(cell: Cell, run: Run, j: int, relaxed_v: float, control: int, target: float) -> tuple[float, float]:
    """Evaluate moment j for its main current; return the control's residual and its slope with that current alone."""
    at = run.at
    eta, eta_slope, run.depth_slope[ETA_BY_DEPTH, j] = charge_transfer(cell, at[X, j], at[T, j], at[MAIN, j])
    node_v = at[SLOW_V, j] + relaxed_v + eta
    side, side_slope = side_current(cell, node_v, at[T, j])
    total = at[MAIN, j] + side
    terminal_v = node_v + at[OHM, j] * total
    at[ETA, j], at[NODE_V, j], at[SIDE, j], at[SIDE_SLOPE, j] = eta, node_v, side, side_slope
    at[TOTAL, j], at[TERMINAL_V, j], at[ETA_SLOPE, j] = total, terminal_v, eta_slope
    total_slope = 1.0 + side_slope * eta_slope
    if control == CURRENT_CONTROL:
        return total - target, total_slope
    if control == VOLTAGE_CONTROL:
        return terminal_v - target, eta_slope + at[OHM, j] * total_slope
    slope = (eta_slope + at[OHM, j] * total_slope) * total + terminal_v * total_slope
    return terminal_v * total - target, slope


@inlined
def place_start(cell: Cell, run: Run) -> None:
    """Fill the start column with what the state alone decides."""
    at, state = run.at, run.state
    at[X, START], at[T, START], at[HYSTERESIS_V, START] = state[DEPTH], state[TEMPERATURE], state[HYSTERESIS]
    circuit_at(cell, run, START)
    relaxed = 0.0
    for k in range(cell.pairs + cell.acceptance):
        relaxed += state[RELAXATIONS + k]
        run.value[k, START] = state[RELAXATIONS + k]
    run.relaxed_v = relaxed


@kernel
def solve_start(cell: Cell, run: Run, control: int, target: float, guess: float) -> bool:
    """Solve the circuit at the start, which must be placed, for its currents; False where that fails.

    The residual rises with the current and bends upwards, so Newton's iteration cannot circle.
    """
    at, relaxed = run.at, run.relaxed_v
    at[MAIN, START] = guess
    if cell.transfer == 0 and control != POWER_CONTROL and at[OHM, START] > 0.0:
        # The side current does not depend on the main one.
        finish_moment(cell, run, START, relaxed, control, target)
        node_v, ohm = at[NODE_V, START], at[OHM, START]
        total = target if control == CURRENT_CONTROL else (target - node_v) / ohm
        at[TOTAL, START], at[MAIN, START] = total, total - at[SIDE, START]
        at[TERMINAL_V, START] = node_v + ohm * total
        return math.isfinite(at[MAIN, START] + total)
    scale = abs(target) + 1e-9
    for _ in range(400):
        residual, slope = finish_moment(cell, run, START, relaxed, control, target)
        if not math.isfinite(residual):
            return False
        change = residual / slope
        if abs(residual) <= 2e-15 * scale or abs(change) <= 1e-16 * abs(at[MAIN, START]):
            return True
        at[MAIN, START] -= change
        if abs(change) <= 1e-9 * abs(at[MAIN, START]):
            finish_moment(cell, run, START, relaxed, control, target)
            return True
    # Near full the main current is the difference of two a billion times its size: its last digits are noise.
    residual, _ = finish_moment(cell, run, START, relaxed, control, target)
    return bool(abs(residual) <= _NOISE * abs(target))
