"""A population of stage currents at once: time, temperature and voltage of each candidate's charge.

Within a piece of the grid the voltage of a pair is exact for a resistance that is a cubic in SOC; the temperature obeys
a linear equation whose homogeneous solution is exact and whose forcing is integrated by Gauss's rule.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined, kernel
from pipeline.objective.staging_grid import NODES, ORDER, PLACES, Grid

Array = NDArray[np.float64]

_END = ORDER + 1
_PLACES = ORDER + 2


def _integration() -> Array:
    """Return the integrals of the basis functions of the Gauss nodes from 0 to each node and to 1."""
    basis = np.linalg.inv(np.vander(2.0 * NODES - 1.0, increasing=True))
    ends = 2.0 * PLACES[1:, None] - 1.0
    powers = np.arange(1, ORDER + 1)
    return np.asarray(0.5 * ((ends**powers - (-1.0) ** powers) / powers) @ basis)


def _barycentric() -> Array:
    gaps = PLACES[:, None] - PLACES[None, :] + np.eye(len(PLACES))
    return np.asarray(1.0 / np.prod(4.0 * gaps, axis=1))


_INTEGRALS = _integration()
_BARYCENTRIC = _barycentric()

END_K, PEAK_K, END_V, PEAK_V = range(4)
"""Columns of what is found of each piece: rise at its end and highest rise [K], last and highest voltage [V]."""
FOUND = 4
# Share of a piece within which a maximum is found; its value then has all its digits.
_SETTLED = 1e-7


@inlined
def _between(values: Array, place: float) -> float:
    """Return the polynomial through the values at PLACES, elsewhere."""
    above, below = 0.0, 0.0
    for j in range(_PLACES):
        gap = place - PLACES[j]
        if gap == 0.0:
            return float(values[j])
        weight = _BARYCENTRIC[j] / gap
        above += weight * values[j]
        below += weight
    return above / below


@inlined
def _highest(values: Array) -> float:
    """Return the maximum over a piece: an end, or that of the polynomial about its highest place.

    By parabolas through the highest point and its neighbours, each shrinking the bracket they span.
    """
    best = 0
    for j in range(1, _END + 1):
        if values[j] > values[best]:
            best = j
    if best == 0 or best == _END:
        return float(values[best])
    low, top, high = PLACES[best - 1], PLACES[best], PLACES[best + 1]
    at_low, at_top, at_high = values[best - 1], values[best], values[best + 1]
    for _ in range(12):
        left, right = (top - low) * (at_top - at_high), (high - top) * (at_top - at_low)
        if not left + right > 0.0:
            break
        step = 0.5 * ((high - top) * right - (top - low) * left) / (left + right)
        if abs(step) < _SETTLED:
            break
        trial = top + step
        value = _between(values, trial)
        if value > at_top:
            if step > 0.0:
                low, at_low = top, at_top
            else:
                high, at_high = top, at_top
            top, at_top = trial, value
        elif step > 0.0:
            high, at_high = trial, value
        else:
            low, at_low = trial, value
    return float(at_top)


@kernel
def charge_stages(grid: Grid, currents: Array, room: Array, state: Array, found: Array) -> None:
    """Charge through the stages with each candidate's currents.

    Arguments
    ---------
    grid : battery and stages.
    currents : of the battery [A], (n, stages).
    room : to work in, (4, ORDER + 2).
    state : rise [K] and voltage of each pair [V] at the start, afterwards at the end, (n, 1 + pairs).
    found : is written, (n, pieces, FOUND).
    """
    forcing, rise, decay, volts = room[0], room[1], room[2], room[3]
    per_heat = grid.cells / grid.heat_capacity_j_k
    cooling = 1.0 / (grid.heat_capacity_j_k * grid.thermal_resistance_k_w)
    for n in range(len(currents)):
        warm, pair_v = state[n, 0], state[n, 1:]
        for p in range(len(grid.stage)):
            current = currents[n, grid.stage[p]]
            length_s = grid.charge_as[p] / current
            to_rise = per_heat * length_s
            for j in range(_PLACES):
                ohmic = current * grid.series_ohm[p, j]
                forcing[j] = to_rise * current * ohmic + grid.reversible[p, j]
                volts[j] = grid.open_v[p, j] + ohmic
                decay[j] = math.exp(-cooling * length_s * PLACES[j]) * grid.warming[p, j]
            for k in range(len(grid.tau_s)):
                _relax(grid, p, k, current, length_s, to_rise, pair_v, volts, forcing)
            for j in range(_PLACES):
                forcing[j] /= decay[j]
            rise[0] = warm
            for j in range(1, _PLACES):
                total = warm
                for m in range(ORDER):
                    total += _INTEGRALS[j - 1, m] * forcing[m + 1]
                rise[j] = decay[j] * total
            for j in range(_PLACES):
                volts[j] = grid.cells * (volts[j] + grid.entropic[p, j] * rise[j])
            warm = rise[_END]
            row = found[n, p]
            row[END_K], row[PEAK_K] = warm, _highest(rise)
            row[END_V], row[PEAK_V] = volts[_END], _highest(volts)
        state[n, 0] = warm


@inlined
def _relax(
    grid: Grid,
    p: int,
    k: int,
    current: float,
    length_s: float,
    to_rise: float,
    pair_v: Array,
    volts: Array,
    forcing: Array,
) -> None:
    """Follow pair k through piece p; add its voltage, and what its heat does to the temperature."""
    z = length_s / grid.tau_s[k]
    start_v = pair_v[k]
    c, conductance, drift = grid.cubic_ohm[p, k], grid.conductance[p, k], grid.drift[p, k]
    for j in range(_PLACES):
        at = PLACES[j]
        passed = 1.0 - math.exp(-z * at)
        # Responses to u^p of z dv/du = z (u^p - v): w_p = u^p - (p / z) w_(p-1).
        first = at - passed / z
        second = at * at - 2.0 / z * first
        third = at * at * at - 3.0 / z * second
        driven = c[0] * passed + c[1] * first + c[2] * second + c[3] * third
        v = start_v * (1.0 - passed) + current * driven
        volts[j] += v
        forcing[j] += to_rise * v * v * (conductance[j] - current * drift[j])
        pair_v[k] = v
