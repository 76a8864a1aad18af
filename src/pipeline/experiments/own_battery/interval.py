"""One interval of a replay: the current divided between the reactions, pairs and depth taken on, and the heat of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    ENTROPIC,
    FIRST_PAIR,
    OPEN_CIRCUIT,
    REFERENCE_K,
    SERIES,
    Cell,
    hysteresis_at,
    side_current,
)
from pipeline.cell.curves import factor_and_slope, value_and_slope
from pipeline.charge.moment import charge_transfer
from pipeline.jit import inlined, kernel

Array = NDArray[np.float64]
LEAST_DEPTH = 1e-9
"""Where 1 - SOC is held for the curves when a current asks for more than full."""
_ITERATIONS = 60
# Rows of the scratch, a column for each relaxation: value, forcing, resistance at both ends of an interval; what is
# left of a value, and what a forcing straight in time adds by its start and by its end; the length these hold for; a
# place for values to come back to.
VALUE, _FORCING, _OHM, _END_OHM, _LEFT, _BY_START, _BY_END, _LENGTH, _BEFORE, SAVED, ROWS = range(11)


@inlined
def inside(x: float) -> float:
    """Return 1 - SOC where the curves hold."""
    return min(max(x, LEAST_DEPTH), 1.0)


@inlined
def series_ohm(cell: Cell, x: float, kelvin: float) -> float:
    """Return the series resistance of one cell [ohm]."""
    return float(value_and_slope(cell, SERIES, inside(x))[0] * factor_and_slope(cell, 0, kelvin)[0])


@inlined
def _pair(cell: Cell, k: int, x: float, kelvin: float) -> tuple[float, float]:
    """Return the resistance of a pair, the acceptance pair being the last, and its slope with x."""
    factor = factor_and_slope(cell, 1 + k, kelvin)[0]
    if k == cell.pairs:
        ohm = cell.acceptance_ohm / x * factor
        return ohm, -ohm / x
    ohm, slope = value_and_slope(cell, FIRST_PAIR + k, x)
    return ohm * factor, slope * factor


@kernel
def at_once(
    cell: Cell, scratch: Array, x: float, kelvin: float, zone: float, total: float, guess: float
) -> tuple[float, float, float, float]:
    """Divide a current at one moment, the pairs as they are: main and side current, node voltage, overpotential."""
    within = inside(x)
    slow = value_and_slope(cell, OPEN_CIRCUIT, within)[0] + zone
    slow += value_and_slope(cell, ENTROPIC, within)[0] * (kelvin - REFERENCE_K)
    for k in range(cell.pairs + cell.acceptance):
        slow += scratch[VALUE, k]
    if cell.side == 0:
        eta = charge_transfer(cell, within, kelvin, total)[0]
        return total, 0.0, slow + eta, eta
    main = guess if cell.transfer == 1 else total
    eta, side = 0.0, 0.0
    for _ in range(_ITERATIONS):
        eta, eta_slope, _by_depth = charge_transfer(cell, within, kelvin, main)
        side, side_slope = side_current(cell, slow + eta, kelvin)
        if cell.transfer == 0:
            main = total - side
            break
        change = (main + side - total) / (1.0 + side_slope * eta_slope)
        main -= change
        if abs(change) <= 1e-12 * (abs(total) + 1e-6):
            break
    return main, side, slow + eta, eta


@kernel
def _weigh(cell: Cell, scratch: Array, length: float) -> None:
    """Write the weights of an interval of some length for every relaxation."""
    scratch[_LENGTH, 0] = length
    for k in range(cell.relaxations):
        z = length / cell.tau_s[k]
        gone = -math.expm1(-z)
        scratch[_LEFT, k] = 1.0 - gone
        scratch[_BY_START, k] = gone / z - (1.0 - gone)
        scratch[_BY_END, k] = 1.0 - gone / z


@kernel
def advance(
    cell: Cell, scratch: Array, x: float, kelvin: float, zone: float, main: float, total: float, length: float
) -> tuple[float, float, float, float, float, float]:
    """Take one interval; the scratch's values become those of its end, its forcings are written.

    Returns
    -------
    1 - SOC, hysteresis [V], main and side current [A], node voltage [V] and overpotential [V] at the end.
    """
    relaxing = cell.pairs + cell.acceptance
    if scratch[_LENGTH, 0] != length:
        _weigh(cell, scratch, length)
    start_within = inside(x)
    for k in range(relaxing):
        ohm = _pair(cell, k, start_within, kelvin)[0]
        scratch[_OHM, k], scratch[_FORCING, k], scratch[_BEFORE, k] = ohm, ohm * main, scratch[VALUE, k]
        scratch[VALUE, k] = scratch[_LEFT, k] * scratch[VALUE, k] + scratch[_BY_START, k] * ohm * main
    start = main
    # A straight line where 1 - SOC moves little; where it would be used up, the end alone, which cannot swing.
    share = abs(start) * length * cell.per_as / max(x, LEAST_DEPTH)
    by_end = 0.5 + 0.5 * min(1.0, share * share) if cell.side == 1 else 0.5
    first, last = (1.0 - by_end) * length * cell.per_as, by_end * length * cell.per_as
    most = (x - first * start) / last
    ends = total if cell.side == 0 else min(main, total)
    low, high = -math.inf, most
    end_x = x
    side, node, eta = 0.0, 0.0, 0.0
    for _ in range(_ITERATIONS):
        end_x = x - first * start - last * ends
        within = inside(end_x)
        moved = -last if within == end_x else 0.0
        open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, within)
        entropy, entropy_slope = value_and_slope(cell, ENTROPIC, within)
        warmer = kelvin - REFERENCE_K
        eta, eta_slope, eta_by_depth = charge_transfer(cell, within, kelvin, ends)
        node = open_v + entropy * warmer + eta
        slope = eta_slope + (open_slope + entropy_slope * warmer + eta_by_depth) * moved
        if cell.hysteresis == 1:
            held, held_slope = hysteresis_at(cell, zone, end_x - x)
            node += held
            slope += held_slope * moved
        for k in range(relaxing):
            ohm, ohm_slope = _pair(cell, k, within, kelvin)
            scratch[_END_OHM, k] = ohm
            weight = scratch[_BY_END, k]
            value = scratch[VALUE, k] + weight * ohm * ends
            if k == cell.pairs and value < 0.0:
                continue
            node += value
            slope += weight * (ohm + ohm_slope * moved * ends)
        if cell.side == 0:
            break
        side, side_slope = side_current(cell, node, kelvin)
        missed = ends + side - total
        if missed > 0.0:
            high = min(high, ends)
        else:
            low = max(low, ends)
        change = missed / (1.0 + side_slope * slope)
        if abs(change) <= 1e-12 * (abs(total) + 1e-6):
            break
        ends -= change
        if not low < ends < high:
            ends = 0.5 * (low + high) if math.isfinite(low) and math.isfinite(high) else ends
            if not ends < most:
                ends = 0.5 * (most + min(start, total))
    for k in range(relaxing):
        scratch[VALUE, k] += scratch[_BY_END, k] * scratch[_END_OHM, k] * ends
        if k == cell.pairs:
            scratch[VALUE, k] = max(scratch[VALUE, k], 0.0)
    held = hysteresis_at(cell, zone, end_x - x)[0] if cell.hysteresis == 1 else zone
    return end_x, held, ends, side, node, eta


@kernel
def point_heat(
    cell: Cell, x: float, kelvin: float, zone: float, main: float, side: float, node: float, eta: float
) -> float:
    """Return the heat of one cell at a moment without that of its series resistance and pairs [W]."""
    within = inside(x)
    entropy = value_and_slope(cell, ENTROPIC, within)[0]
    if cell.thermoneutral == 1:
        open_v = value_and_slope(cell, OPEN_CIRCUIT, within)[0] + entropy * (kelvin - REFERENCE_K)
        reversible = main * (open_v - cell.thermoneutral_v)
    else:
        reversible = main * kelvin * entropy
    held = zone if cell.hysteresis == 1 else 0.0
    return float(reversible + (eta + held) * main + side * (node - cell.gas_v))


@kernel
def pair_heat(
    cell: Cell,
    scratch: Array,
    start_x: float,
    end_x: float,
    start_k: float,
    end_k: float,
    start_main: float,
    end_main: float,
    start_side: float,
    end_side: float,
    length: float,
) -> float:
    """Return the mean heat of one cell's pairs and of recombining gas over an interval [W].

    What goes into a pair, mean current times mean voltage, less the change of its store C v^2 / 2; the mean voltage
    follows from the pair's own equation. The gas works the same way, and its state is moved on here.
    """
    heat = 0.0
    mean_a = 0.5 * (start_main + end_main)
    for k in range(cell.pairs + cell.acceptance):
        tau, first, last = cell.tau_s[k], scratch[_OHM, k], scratch[_END_OHM, k]
        if first <= 0.0 or last <= 0.0:
            continue
        before, after = scratch[_BEFORE, k], scratch[VALUE, k]
        mean_v = 0.5 * (scratch[_FORCING, k] + last * end_main) - (after - before) * tau / length
        if k == cell.pairs and after == 0.0:
            # Discharged on the way and held there: straight down to nothing.
            mean_v = 0.5 * before
        heat += mean_a * mean_v - 0.5 * tau * (after * after / last - before * before / first) / length
    if cell.recombination == 1:
        k = cell.relaxations - 1
        before = scratch[VALUE, k]
        after = scratch[_LEFT, k] * before + scratch[_BY_START, k] * start_side + scratch[_BY_END, k] * end_side
        heat += cell.gas_v * (0.5 * (start_side + end_side) - (after - before) * cell.tau_s[k] / length)
        scratch[VALUE, k] = after
    return heat
