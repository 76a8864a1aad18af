"""A measured current replayed on the cell circuit: a population of cells at once, row by row of one record.

Between two rows the current is a straight line, and so is the main current. Depth of discharge follows by quadrature,
every pair exactly for its forcing `R i` taken as a straight line, and one scalar equation a row divides the current
between the main and the side reaction. The circuit's functions of SOC and temperature are those of the charge engine.
"""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    ENTROPIC,
    EXCHANGE,
    FIRST_PAIR,
    MOST_RELAXATIONS,
    OPEN_CIRCUIT,
    REFERENCE_K,
    SERIES,
    THERMAL_V_PER_K,
    Cell,
    hysteresis_at,
    side_current,
)
from pipeline.cell.curves import factor_and_slope, value_and_slope
from pipeline.jit import inlined, kernel

Array = NDArray[np.float64]
LEAST_DEPTH = 1e-9
"""Where 1 - SOC is held for the curves when a current asks for more than full."""
_ITERATIONS = 60
# Rows of the scratch, a column for each relaxation: value, forcing, resistance at both ends of an interval; what is
# left of a value, and what a forcing straight in time adds by its start and by its end; the length these hold for.
_VALUE, _FORCING, _OHM, _END_OHM, _LEFT, _BY_START, _BY_END, _LENGTH, _BEFORE, _ROWS = range(10)


class Drive(NamedTuple):
    """What is replayed, a value a row, shape (m,) each.

    Arguments
    ---------
    time_s : rising; equal times are a jump.
    before_a, after_a : battery current just before and just after the row, straight from row to row [A].
    read_a : current with which the row's voltage was read, for the drop at the series resistance [A].
    ambient_k : temperature of the surroundings [K].
    given_k : temperature imposed on the cell [K]; NaN: that of its own heat.
    """

    time_s: Array
    before_a: Array
    after_a: Array
    read_a: Array
    ambient_k: Array
    given_k: Array


class Replay(NamedTuple):
    """Voltage of the battery [V], temperature [K] and 1 - SOC, shape (n, m) each."""

    voltage_v: Array
    temperature_k: Array
    depth: Array


def replays(cells: NDArray[Any], soc: Array, start_k: Array, drive: Drive) -> Replay:
    """Replay a record on a population of cells.

    Arguments
    ---------
    cells : records of `CELL`, shape (n,).
    soc, start_k : state of charge and temperature at the start, the pairs discharged, shape (n,).
    drive : the record, m rows.
    """
    count, rows = len(cells), len(drive.time_s)
    found = Replay(*(np.empty((count, rows)) for _ in range(3)))
    parts = min(count, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1)
    edges = np.linspace(0, count, parts + 1).astype(int)

    def run(part: int) -> None:
        here = slice(edges[part], edges[part + 1])
        made = Replay(*(one[here] for one in found))
        _population(cells[here], soc[here], start_k[here], *drive, *made, _scratch())

    if parts < 2:
        run(0)
    else:
        with ThreadPoolExecutor(max_workers=parts) as pool:
            list(pool.map(run, range(parts)))
    return found


def _scratch() -> Array:
    return np.zeros((_ROWS, MOST_RELAXATIONS))


@kernel
def _population(
    cells: NDArray[Any],
    soc: Array,
    start_k: Array,
    time_s: Array,
    before_a: Array,
    after_a: Array,
    read_a: Array,
    ambient_k: Array,
    given_k: Array,
    voltage_v: Array,
    temperature_k: Array,
    depth: Array,
    scratch: Array,
) -> None:
    for j in range(len(cells)):
        _follow(
            cells[j], soc[j], start_k[j], time_s, before_a, after_a, read_a, ambient_k, given_k,
            voltage_v[j], temperature_k[j], depth[j], scratch,
        )  # fmt: skip


@kernel
def _follow(
    cell: Cell,
    soc: float,
    start_k: float,
    time_s: Array,
    before_a: Array,
    after_a: Array,
    read_a: Array,
    ambient_k: Array,
    given_k: Array,
    voltage_v: Array,
    temperature_k: Array,
    depth: Array,
    scratch: Array,
) -> None:
    """Follow one cell through a record."""
    x, kelvin, zone, rising = 1.0 - soc, start_k, cell.hysteresis_start_v, 0.0
    if not math.isnan(given_k[0]):
        kelvin = given_k[0]
    scratch[:] = 0.0
    main, side, node, eta = _at_once(cell, scratch, x, kelvin, zone, before_a[0], before_a[0])
    ohm = _series(cell, x, kelvin)
    voltage_v[0], temperature_k[0], depth[0] = cell.cells * (node + ohm * read_a[0]), kelvin, x
    for row in range(1, len(time_s)):
        length = time_s[row] - time_s[row - 1]
        first_a, last_a = after_a[row - 1], before_a[row]
        main, side, node, eta = _at_once(cell, scratch, x, kelvin, zone, first_a, main)
        start_x, start_kelvin, start_main, start_side = x, kelvin, main, side
        start_w = _point_heat(cell, x, kelvin, zone, main, side, node, eta)
        if length > 0.0:
            kelvin = start_kelvin + length * rising if math.isnan(given_k[row]) else given_k[row]
            x, zone, main, side, node, eta = _advance(cell, scratch, x, kelvin, zone, main, last_a, length)
            end_w = _point_heat(cell, x, kelvin, zone, main, side, node, eta)
            heat_w = 0.5 * (start_w + end_w) + _pair_heat(
                cell, scratch, start_x, x, start_kelvin, kelvin, start_main, main, start_side, side, length
            )
            old_ohm, ohm = ohm, _series(cell, x, kelvin)
            heat_w += 0.5 * (old_ohm + ohm) * (first_a * first_a + first_a * last_a + last_a * last_a) / 3.0
            around = 0.5 * (ambient_k[row - 1] + ambient_k[row])
            if math.isnan(given_k[row]):
                settled = around + cell.cells * heat_w * cell.thermal_resistance_k_w
                tau = cell.heat_capacity_j_k * cell.thermal_resistance_k_w
                kelvin = settled + (start_kelvin - settled) * math.exp(-length / tau)
                rising = (kelvin - start_kelvin) / length
        else:
            main, side, node, eta = _at_once(cell, scratch, x, kelvin, zone, last_a, main)
            ohm = _series(cell, x, kelvin)
        voltage_v[row], temperature_k[row], depth[row] = cell.cells * (node + ohm * read_a[row]), kelvin, x


@inlined
def _inside(x: float) -> float:
    return min(max(x, LEAST_DEPTH), 1.0)


@inlined
def _series(cell: Cell, x: float, kelvin: float) -> float:
    return float(value_and_slope(cell, SERIES, _inside(x))[0] * factor_and_slope(cell, 0, kelvin)[0])


@inlined
def _pair(cell: Cell, k: int, x: float, kelvin: float) -> tuple[float, float]:
    """Return the resistance of a pair, the acceptance pair being the last, and its slope with x."""
    factor = factor_and_slope(cell, 1 + k, kelvin)[0]
    if k == cell.pairs:
        ohm = cell.acceptance_ohm / x * factor
        return ohm, -ohm / x
    ohm, slope = value_and_slope(cell, FIRST_PAIR + k, x)
    return ohm * factor, slope * factor


@inlined
def _transfer(cell: Cell, x: float, kelvin: float, main: float) -> tuple[float, float, float]:
    """Return the overpotential of the main reaction and its slopes with current and x."""
    if cell.transfer == 0:
        return 0.0, 0.0, 0.0
    exchange, exchange_slope = value_and_slope(cell, EXCHANGE, x)
    scale = 2.0 * THERMAL_V_PER_K * kelvin
    with_current = scale / math.hypot(main, 2.0 * exchange)
    return (
        scale * math.asinh(main / (2.0 * exchange)),
        with_current,
        -with_current * main / exchange * exchange_slope,
    )


@kernel
def _at_once(
    cell: Cell, scratch: Array, x: float, kelvin: float, zone: float, total: float, guess: float
) -> tuple[float, float, float, float]:
    """Divide a current at one moment, the pairs as they are: main and side current, node voltage, overpotential."""
    inside = _inside(x)
    slow = value_and_slope(cell, OPEN_CIRCUIT, inside)[0] + zone
    slow += value_and_slope(cell, ENTROPIC, inside)[0] * (kelvin - REFERENCE_K)
    for k in range(cell.pairs + cell.acceptance):
        slow += scratch[_VALUE, k]
    if cell.side == 0:
        eta = _transfer(cell, inside, kelvin, total)[0]
        return total, 0.0, slow + eta, eta
    main = guess if cell.transfer == 1 else total
    eta, side = 0.0, 0.0
    for _ in range(_ITERATIONS):
        eta, eta_slope, _by_depth = _transfer(cell, inside, kelvin, main)
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
def _advance(
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
    start_inside = _inside(x)
    for k in range(relaxing):
        ohm = _pair(cell, k, start_inside, kelvin)[0]
        scratch[_OHM, k], scratch[_FORCING, k], scratch[_BEFORE, k] = ohm, ohm * main, scratch[_VALUE, k]
        scratch[_VALUE, k] = scratch[_LEFT, k] * scratch[_VALUE, k] + scratch[_BY_START, k] * ohm * main
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
        inside = _inside(end_x)
        moved = -last if inside == end_x else 0.0
        open_v, open_slope = value_and_slope(cell, OPEN_CIRCUIT, inside)
        entropy, entropy_slope = value_and_slope(cell, ENTROPIC, inside)
        warmer = kelvin - REFERENCE_K
        eta, eta_slope, eta_by_depth = _transfer(cell, inside, kelvin, ends)
        node = open_v + entropy * warmer + eta
        slope = eta_slope + (open_slope + entropy_slope * warmer + eta_by_depth) * moved
        if cell.hysteresis == 1:
            held, held_slope = hysteresis_at(cell, zone, end_x - x)
            node += held
            slope += held_slope * moved
        for k in range(relaxing):
            ohm, ohm_slope = _pair(cell, k, inside, kelvin)
            scratch[_END_OHM, k] = ohm
            weight = scratch[_BY_END, k]
            value = scratch[_VALUE, k] + weight * ohm * ends
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
        scratch[_VALUE, k] += scratch[_BY_END, k] * scratch[_END_OHM, k] * ends
        if k == cell.pairs:
            scratch[_VALUE, k] = max(scratch[_VALUE, k], 0.0)
    held = hysteresis_at(cell, zone, end_x - x)[0] if cell.hysteresis == 1 else zone
    return end_x, held, ends, side, node, eta


@kernel
def _point_heat(
    cell: Cell, x: float, kelvin: float, zone: float, main: float, side: float, node: float, eta: float
) -> float:
    """Return the heat of one cell at a moment without that of its series resistance and pairs [W]."""
    inside = _inside(x)
    entropy = value_and_slope(cell, ENTROPIC, inside)[0]
    if cell.thermoneutral == 1:
        open_v = value_and_slope(cell, OPEN_CIRCUIT, inside)[0] + entropy * (kelvin - REFERENCE_K)
        reversible = main * (open_v - cell.thermoneutral_v)
    else:
        reversible = main * kelvin * entropy
    held = zone if cell.hysteresis == 1 else 0.0
    return float(reversible + (eta + held) * main + side * (node - cell.gas_v))


@kernel
def _pair_heat(
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
        before, after = scratch[_BEFORE, k], scratch[_VALUE, k]
        mean_v = 0.5 * (scratch[_FORCING, k] + last * end_main) - (after - before) * tau / length
        if k == cell.pairs and after == 0.0:
            # Discharged on the way and held there: straight down to nothing.
            mean_v = 0.5 * before
        heat += mean_a * mean_v - 0.5 * tau * (after * after / last - before * before / first) / length
    if cell.recombination == 1:
        k = cell.relaxations - 1
        before = scratch[_VALUE, k]
        after = scratch[_LEFT, k] * before + scratch[_BY_START, k] * start_side + scratch[_BY_END, k] * end_side
        heat += cell.gas_v * (0.5 * (start_side + end_side) - (after - before) * cell.tau_s[k] / length)
        scratch[_VALUE, k] = after
    return heat
