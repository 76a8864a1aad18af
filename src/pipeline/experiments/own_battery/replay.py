"""A measurement replayed on the cell circuit: a population of cells at once, row by row of one record.

What drives it is the measured current or, where a charger held a voltage, that voltage up to the charger's current.
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

from pipeline.cell.circuit import MOST_RELAXATIONS, Cell
from pipeline.experiments.own_battery.interval import (
    ROWS,
    SAVED,
    VALUE,
    advance,
    at_once,
    pair_heat,
    point_heat,
    series_ohm,
)
from pipeline.jit import inlined, kernel

Array = NDArray[np.float64]
_MOST_SECANTS, _NEAR_V = 60, 1e-9


class Drive(NamedTuple):
    """What is replayed, a value a row, shape (m,) each.

    Arguments
    ---------
    time_s : rising; equal times are a jump.
    before_a, after_a : battery current just before and just after the row, straight from row to row [A].
    read_a : current with which the row's voltage was read, for the drop at the series resistance [A].
    ambient_k : temperature of the surroundings [K].
    given_k : temperature imposed on the cell [K]; NaN: that of its own heat.
    held_v : voltage held from the row before to the row [V]; NaN: the current is given.
    limit_a : current up to which it is held, with its sign [A]; a charger that holds a voltage takes nothing back.
    """

    time_s: Array
    before_a: Array
    after_a: Array
    read_a: Array
    ambient_k: Array
    given_k: Array
    held_v: Array
    limit_a: Array


class Replay(NamedTuple):
    """Voltage of the battery [V], temperature [K], 1 - SOC and current [A], shape (n, m) each."""

    voltage_v: Array
    temperature_k: Array
    depth: Array
    current_a: Array


def replays(cells: NDArray[Any], soc: Array, start_k: Array, drive: Drive) -> Replay:
    """Replay a record on a population of cells.

    Arguments
    ---------
    cells : records of `CELL`, shape (n,).
    soc, start_k : state of charge and temperature at the start, the pairs discharged, shape (n,).
    drive : the record, m rows.
    """
    count, rows = len(cells), len(drive.time_s)
    found = Replay(*(np.empty((count, rows)) for _ in range(4)))
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
    return np.zeros((ROWS, MOST_RELAXATIONS))


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
    held_v: Array,
    limit_a: Array,
    voltage_v: Array,
    temperature_k: Array,
    depth: Array,
    current_a: Array,
    scratch: Array,
) -> None:
    for j in range(len(cells)):
        _follow(
            cells[j], soc[j], start_k[j], time_s, before_a, after_a, read_a, ambient_k, given_k, held_v, limit_a,
            voltage_v[j], temperature_k[j], depth[j], current_a[j], scratch,
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
    held_v: Array,
    limit_a: Array,
    voltage_v: Array,
    temperature_k: Array,
    depth: Array,
    current_a: Array,
    scratch: Array,
) -> None:
    """Follow one cell through a record."""
    x, kelvin, zone, rising = 1.0 - soc, start_k, cell.hysteresis_start_v, 0.0
    if not math.isnan(given_k[0]):
        kelvin = given_k[0]
    scratch[:] = 0.0
    main, side, node, eta = at_once(cell, scratch, x, kelvin, zone, before_a[0], before_a[0])
    ohm, flowing = series_ohm(cell, x, kelvin), before_a[0]
    voltage_v[0], temperature_k[0], depth[0] = cell.cells * (node + ohm * read_a[0]), kelvin, x
    current_a[0] = read_a[0]
    for row in range(1, len(time_s)):
        length, held = time_s[row] - time_s[row - 1], not math.isnan(held_v[row])
        first_a, last_a, read = after_a[row - 1], before_a[row], read_a[row]
        if held:
            # What flows at the voltage from the start on: that of the row before, but where the voltage sets in.
            wanted = held_v[row] / cell.cells
            first_a = _at_voltage(cell, scratch, x, kelvin, zone, flowing, main, 0.0, wanted, limit_a[row])
        main, side, node, eta = at_once(cell, scratch, x, kelvin, zone, first_a, main)
        start_x, start_kelvin, start_main, start_side = x, kelvin, main, side
        start_w = point_heat(cell, x, kelvin, zone, main, side, node, eta)
        if length > 0.0:
            kelvin = start_kelvin + length * rising if math.isnan(given_k[row]) else given_k[row]
            if held:
                last_a = _at_voltage(cell, scratch, x, kelvin, zone, first_a, main, length, wanted, limit_a[row])
            x, zone, main, side, node, eta = advance(cell, scratch, x, kelvin, zone, main, last_a, length)
            end_w = point_heat(cell, x, kelvin, zone, main, side, node, eta)
            heat_w = 0.5 * (start_w + end_w) + pair_heat(
                cell, scratch, start_x, x, start_kelvin, kelvin, start_main, main, start_side, side, length
            )
            old_ohm, ohm = ohm, series_ohm(cell, x, kelvin)
            heat_w += 0.5 * (old_ohm + ohm) * (first_a * first_a + first_a * last_a + last_a * last_a) / 3.0
            around = 0.5 * (ambient_k[row - 1] + ambient_k[row])
            if math.isnan(given_k[row]):
                settled = around + cell.cells * heat_w * cell.thermal_resistance_k_w
                tau = cell.heat_capacity_j_k * cell.thermal_resistance_k_w
                kelvin = settled + (start_kelvin - settled) * math.exp(-length / tau)
                rising = (kelvin - start_kelvin) / length
        else:
            main, side, node, eta = at_once(cell, scratch, x, kelvin, zone, last_a, main)
            ohm = series_ohm(cell, x, kelvin)
        flowing = last_a
        read = last_a if held else read
        voltage_v[row], temperature_k[row], depth[row] = cell.cells * (node + ohm * read), kelvin, x
        current_a[row] = read


@inlined
def _voltage(
    cell: Cell, scratch: Array, x: float, kelvin: float, zone: float, main: float, total: float, length: float
) -> float:
    """Return the voltage of one cell at the end of an interval with a current there, the pairs left as they were."""
    for k in range(cell.relaxations):
        scratch[SAVED, k] = scratch[VALUE, k]
    if length > 0.0:
        x, _zone, _main, _side, node, _eta = advance(cell, scratch, x, kelvin, zone, main, total, length)
    else:
        _main, _side, node, _eta = at_once(cell, scratch, x, kelvin, zone, total, main)
    for k in range(cell.relaxations):
        scratch[VALUE, k] = scratch[SAVED, k]
    return float(node + series_ohm(cell, x, kelvin) * total)


@kernel
def _at_voltage(
    cell: Cell,
    scratch: Array,
    x: float,
    kelvin: float,
    zone: float,
    guess: float,
    main: float,
    length: float,
    wanted: float,
    limit: float,
) -> float:
    """Return the current at which one cell has a voltage at the end of an interval, between none and a limit.

    The voltage rises with the current: secants inside what is bracketed, halved where these leave it.
    """
    low, high = min(0.0, limit), max(0.0, limit)
    old = min(max(guess, low), high)
    old_v = _voltage(cell, scratch, x, kelvin, zone, main, old, length) - wanted
    new = min(max(old - old_v / (4.0 * series_ohm(cell, x, kelvin) + 1e-9), low), high)
    for _ in range(_MOST_SECANTS):
        if new == old or abs(old_v) < _NEAR_V:
            break
        new_v = _voltage(cell, scratch, x, kelvin, zone, main, new, length) - wanted
        if new_v > 0.0:
            high = min(high, new)
        else:
            low = max(low, new)
        slope = (new_v - old_v) / (new - old)
        old, old_v = new, new_v
        new = old - old_v / slope if slope > 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
    return old
