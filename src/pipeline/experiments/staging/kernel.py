"""A population of stage currents at once: time, temperature and voltage of each candidate's charge.

Within a piece of the grid the voltage of a pair is exact for a resistance that is a cubic in SOC; the temperature obeys
a linear equation whose homogeneous solution is exact and whose forcing is integrated by Gauss's rule.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    ENTROPIC,
    FIRST_PAIR,
    OPEN_CIRCUIT,
    REFERENCE_K,
    SERIES,
    ZERO_CELSIUS_K,
    Cell,
    compile_cell,
)
from pipeline.cell.curves import integral, value_and_slope
from pipeline.cell.records import Battery, Logarithm, Root, Tabulated
from pipeline.jit import inlined, kernel

ORDER = 12
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(ORDER)
NODES: Array = 0.5 * (_POINTS + 1.0)
"""Gauss nodes on [0, 1]; a grid adds both ends, so that each piece has ORDER + 2 places: start, nodes, end."""
PLACES: Array = np.concatenate([[0.0], NODES, [1.0]])
# A transient exp(-u) over one piece is integrated to 1e-11 up to this u; what is below the floor has passed.
_STEEPEST = 12.5
_PASSED = 1e-13


class Grid(NamedTuple):
    """What the kernel needs of a battery and its stages; p pieces, k pairs, g = ORDER + 2 places of a piece."""

    stage: NDArray[np.int64]
    """Stage of each piece, (p,)."""
    charge_as: Array
    """Charge of each piece, of the battery [A s], (p,)."""
    open_v: Array
    """U at the ambient temperature, per cell [V], (p, g)."""
    entropic: Array
    """dU/dT per cell [V/K], (p, g)."""
    warming: Array
    """What the reaction's entropy alone multiplies the temperature rise by, from the start of the piece, (p, g)."""
    reversible: Array
    """Rise per unit of the piece by the reaction at the ambient temperature [K], (p, g)."""
    series_ohm: Array
    """Series resistance per cell [ohm], (p, g)."""
    cubic_ohm: Array
    """Resistance of each pair as a cubic in the place within the piece [ohm], (p, k, 4)."""
    conductance: Array
    """Reciprocal of the resistance of each pair [S], (p, k, g)."""
    drift: Array
    """What the changing capacitance takes from it per ampere [S/A], (p, k, g)."""
    tau_s: Array
    """Time constant of each pair [s], (k,)."""
    cells: float
    heat_capacity_j_k: float
    thermal_resistance_k_w: float
    ambient_k: float
    slowest_a: float
    """Least current for which the grid is fine enough [A]."""
    capacity_ah: float


def make_grid(battery: Battery, edges: Sequence[float], ambient_c: float, slowest_a: float) -> Grid:
    """Return the grid of a battery's stages.

    Arguments
    ---------
    edges : state of charge at the start and at the end of each stage, rising, (stages + 1,).
    ambient_c : ambient temperature, also the battery's at the start [degC].
    slowest_a : least current that will be asked for [A]; the smaller, the finer the grid.

    Raises
    ------
    ValueError : a battery whose current does not all go through its main reaction, or with other curves than tables,
        polynomials and numbers.
    """
    _check(battery, edges)
    cell = compile_cell(battery)
    bounds = _bounds(battery, np.asarray(edges, dtype=float), slowest_a)
    stage = np.searchsorted(np.asarray(edges)[1:-1], bounds[:-1] + 1e-12, side="right")
    depth = 1.0 - (bounds[:-1, None] + np.diff(bounds)[:, None] * PLACES)
    ambient_k = ambient_c + ZERO_CELSIUS_K
    charge = np.diff(bounds) * float(cell["charge_as"])
    open_v, _ = _curve(cell, OPEN_CIRCUIT, depth)
    entropic, _ = _curve(cell, ENTROPIC, depth)
    open_v = open_v + entropic * (ambient_k - REFERENCE_K)
    per_heat = float(cell["cells"]) / float(cell["heat_capacity_j_k"])
    stored = np.array([[integral(cell, ENTROPIC, x) for x in row] for row in depth])
    reversible = entropic * ambient_k
    if cell["thermoneutral"]:
        reversible = open_v - float(cell["thermoneutral_v"])
    pairs = range(int(cell["pairs"]))
    found = [_curve(cell, FIRST_PAIR + k, depth) for k in pairs]
    shape = (len(bounds) - 1, 0, len(PLACES))
    resistance = np.stack([value for value, _ in found], axis=1) if found else np.zeros(shape)
    slope = np.stack([slope for _, slope in found], axis=1) if found else np.zeros(shape)
    tau = np.array(cell["tau_s"][: len(pairs)])
    conductance = np.divide(1.0, resistance, out=np.zeros_like(resistance), where=resistance > 0.0)
    return Grid(
        stage=stage.astype(np.int64),
        charge_as=charge,
        open_v=open_v,
        entropic=entropic,
        warming=np.exp(per_heat * float(cell["charge_as"]) * (stored - stored[:, :1])),
        reversible=per_heat * charge[:, None] * reversible,
        series_ohm=_curve(cell, SERIES, depth)[0],
        cubic_ohm=_cubics(resistance),
        conductance=conductance,
        drift=0.5 * tau[:, None] * slope * conductance**2 * float(cell["per_as"]),
        tau_s=tau,
        cells=float(cell["cells"]),
        heat_capacity_j_k=float(cell["heat_capacity_j_k"]),
        thermal_resistance_k_w=float(cell["thermal_resistance_k_w"]),
        ambient_k=ambient_k,
        slowest_a=slowest_a,
        capacity_ah=battery.capacity_in_use_ah,
    )


def _check(battery: Battery, edges: Sequence[float]) -> None:
    for part in ("side_reaction", "acceptance", "charge_transfer"):
        if getattr(battery, part) is not None:
            raise ValueError(f"battery has {part}; stages are searched for batteries of resistances and pairs alone")
    if any(warmth is not None for warmth in battery.warmths):
        raise ValueError("battery has resistances that depend on temperature; stages are searched without")
    for name, pair in battery.pairs.items():
        if isinstance(pair.resistance_ohm, Logarithm | Root):
            raise ValueError(f"pairs.{name}.resistance_ohm must be a number, a polynomial or a table")
    if len(edges) < 2 or any(b <= a for a, b in pairwise(edges)) or edges[0] < 0 or edges[-1] >= 1:
        raise ValueError(f"the edges of the stages are {list(edges)}; they must rise from 0 or more to less than 1")


def _bounds(battery: Battery, edges: Array, slowest_a: float) -> Array:
    """Return the ends of the pieces: edges, knots, and where a stage's transient asks for shorter pieces."""
    curves = [battery.open_circuit_voltage_v, battery.entropic_coefficient_v_k, battery.series_resistance_ohm]
    curves += [pair.resistance_ohm for pair in battery.pairs.values()]
    knots = {round(soc, 12) for curve in curves if isinstance(curve, Tabulated) for soc in curve.soc}
    inside = np.array(sorted(soc for soc in knots if edges[0] < soc < edges[-1]))
    bounds = sorted({round(float(soc), 12) for soc in (*edges, *inside)})
    fastest = min((pair.time_constant_s for pair in battery.pairs.values()), default=np.inf)
    per_soc = 2.0 * 3600.0 * battery.capacity_in_use_ah / slowest_a / fastest
    fine = [bounds[0]]
    for low, high in pairwise(bounds):
        begun = edges[np.searchsorted(edges, low + 1e-12, side="right") - 1]
        fine += _split(low - begun, high - begun, per_soc, begun)
    return np.array(fine)


def _split(low: float, high: float, per_soc: float, begun: float) -> list[float]:
    """Return the ends of the pieces that a stretch of a stage is cut into, the first left out."""
    steep, passed = (high - low) * per_soc > _STEEPEST, np.exp(-low * per_soc) < _PASSED
    if not steep or passed:
        return [begun + high]
    middle = 0.5 * (low + high)
    return _split(low, middle, per_soc, begun) + _split(middle, high, per_soc, begun)


def _curve(cell: Cell, row: int, depth: Array) -> tuple[Array, Array]:
    """Return a curve and its slope with 1 - SOC at many places; both ends of a piece are taken from inside it."""
    inner = depth.copy()
    inner[:, 0] -= 1e-14
    inner[:, -1] += 1e-14
    pairs = np.array([[_at(cell, row, x) for x in line] for line in inner])
    return pairs[..., 0], pairs[..., 1]


def _at(cell: Any, row: int, x: float) -> tuple[float, float]:
    return value_and_slope(cell, row, x)


def _cubics(resistance: Array) -> Array:
    """Return the cubic through four places of each piece, which is the curve itself where it is a cubic there."""
    places = [0, 1 + ORDER // 3, ORDER - ORDER // 3, ORDER + 1]
    inverse = np.linalg.inv(np.vander(PLACES[places], increasing=True))
    return np.asarray(np.einsum("cq,pkq->pkc", inverse, resistance[..., places]))


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
