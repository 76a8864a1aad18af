"""What a stage makes of the state it begins with, tabulated over its current: a staged charge for a few sums.

Under a constant current the voltage v of a pair at the end of a stage is linear in that at its start; the temperature
rise is linear in its own start and of the second degree in the voltages:

    v' = K v + L,    rise' = A rise + B + sum over the pairs of (C v + D v^2)

A to L depend on the current alone and smoothly so. Each is a polynomial on each of many short spans of the current.

The maps know no limits: they serve where no currents of the range can reach one, which `never_limited` tells from the
size of a battery's parts alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from pipeline.experiments.staging.kernel import FOUND, ORDER, Grid, charge_stages
from pipeline.experiments.staging.records import Currents
from pipeline.jit import inlined, jit
from pipeline.search.moves import Compiled

Array = NDArray[np.float64]

_DEGREE = 7
_TERMS = _DEGREE + 1
_FOUR = 4
_HEAD = 8
_FEWEST_SPANS, _MOST_SPANS = 64, 512
_ACCURACY = 1e-13
"""Of a polynomial between its nodes, over the largest value of its function."""
_SLACK = 1e-9
"""How far beyond its range a current still counts as rounded, over a span."""
_START_K, _START_V = 10.0, 0.1
_MARGIN = 1.02
"""By how much a curve may rise between two places of the grid."""


class Maps(NamedTuple):
    """The functions of each stage on a range of currents."""

    low_a: float
    high_a: float
    table: Array
    """Coefficients in the place on the span, -1 to 1, (stages, spans, 1 + pairs, powers, 4). The first four functions
    are the stage's time [s], A, B and nothing; then come C, D, K and L of each pair."""


def stage_maps(grid: Grid, currents: Currents) -> Maps:
    """Return the maps of a grid's stages, on as many spans as their accuracy asks for."""
    spans = _FEWEST_SPANS
    while True:
        maps = Maps(currents.low, currents.high, _table(grid, currents, spans))
        if spans >= _MOST_SPANS or _error(grid, maps) < _ACCURACY:
            return maps
        spans *= 2


def weighted(maps: Maps, of_time: float, of_rise: float, constant: float, positive: bool) -> Compiled:
    """Return `of_time` x time [s] + `of_rise` x rise [K] + constant as a compiled objective.

    Arguments
    ---------
    positive : whether the rise is the sum of the stages' rises without their falls, or the rise at the end.
    """
    _, spans, quads, _, _ = maps.table.shape
    head = [maps.low_a, spans / (maps.high_a - maps.low_a), spans, quads, of_time, of_rise, constant, positive]
    return Compiled(_weighted, np.concatenate([head, maps.table.ravel()]))


def _weighted(numbers: Array, currents: Array, values: Array) -> None:
    """Write the weighted sums of charges; not a number where a current is out of range."""
    spans, quads, (count, stages) = int(numbers[2]), int(numbers[3]), currents.shape
    of_time, of_rise, constant, positive = numbers[4], numbers[5], numbers[6], numbers[7] > 0.0
    table, pair_v = numbers[_HEAD:].reshape(stages, spans, quads, _TERMS, _FOUR), np.empty(quads - 1)
    span, place = _located(currents, numbers[0], numbers[1], spans)
    for n in range(count):
        time, rise, risen = 0.0, 0.0, 0.0
        pair_v[:] = 0.0
        for stage in range(stages):
            maps, at = table[stage, span[n, stage]], place[n, stage]
            lasts, kept, warmed, _ = _four(maps[0], at)
            end = kept * rise + warmed
            for k in range(quads - 1):
                linear, square, relaxed, driven = _four(maps[1 + k], at)
                end += pair_v[k] * (linear + square * pair_v[k])
                pair_v[k] = relaxed * pair_v[k] + driven
            time += lasts
            risen += max(end - rise, 0.0) if positive else end - rise
            rise = end
        values[n] = of_time * time + of_rise * risen + constant


@jit
def _located(currents: Array, low: float, per_a: float, spans: int) -> tuple[NDArray[np.int64], Array]:
    """Return the span of each current and its place there, -1 to 1; no place where it is out of range."""
    span, place = np.empty(currents.shape, dtype=np.int64), np.empty(currents.shape)
    for n in range(currents.shape[0]):
        for stage in range(currents.shape[1]):
            along = (currents[n, stage] - low) * per_a
            inside = -_SLACK <= along <= spans + _SLACK
            whole = min(max(np.floor(along), 0.0), spans - 1.0) if inside else 0.0
            span[n, stage] = int(whole)
            place[n, stage] = 2.0 * (along - whole) - 1.0 if inside else np.nan
    return span, place


@inlined
def _four(powers: Array, place: float) -> tuple[float, float, float, float]:
    """Return four polynomials at a place, from their coefficients (powers, 4)."""
    # Written out, because four numbers side by side in memory are one operation.
    a, b, c, d = powers[_DEGREE, 0], powers[_DEGREE, 1], powers[_DEGREE, 2], powers[_DEGREE, 3]
    for power in range(_DEGREE - 1, -1, -1):
        a = a * place + powers[power, 0]
        b = b * place + powers[power, 1]
        c = c * place + powers[power, 2]
        d = d * place + powers[power, 3]
    return a, b, c, d


def _table(grid: Grid, currents: Currents, spans: int) -> Array:
    """Return the coefficients, from the functions at Chebyshev's nodes of each span."""
    nodes = chebyshev.chebpts1(_TERMS)
    to_powers = np.zeros((_TERMS, _TERMS))
    for order in range(_TERMS):
        to_powers[: order + 1, order] = chebyshev.cheb2poly(np.eye(order + 1)[order])
    fit = to_powers @ np.linalg.inv(chebyshev.chebvander(nodes, _DEGREE))
    functions = _functions(grid, _places(currents.low, currents.high, spans, nodes))
    return np.ascontiguousarray(np.einsum("pm,stmqf->stqpf", fit, functions))


def _places(low_a: float, high_a: float, spans: int, nodes: Array) -> Array:
    """Return the currents of some places on each span, (spans, places)."""
    return low_a + (high_a - low_a) / spans * (np.arange(spans)[:, None] + 0.5 * (nodes + 1.0))


def _functions(grid: Grid, currents: Array) -> Array:
    """Return the functions of every stage at currents of any shape, (stages, ..., 1 + pairs, 4)."""
    stages, pairs, flat = int(grid.stage[-1]) + 1, len(grid.tau_s), currents.ravel()
    found = np.zeros((stages, len(flat), 1 + pairs, _FOUR))
    for stage in range(stages):
        of_stage = _only(grid, stage)
        resting = _ends(of_stage, flat, np.zeros(1 + pairs))
        unit = np.eye(1 + pairs)
        found[stage, :, 0, 0] = of_stage.charge_as.sum() / flat
        found[stage, :, 0, 1] = (_ends(of_stage, flat, _START_K * unit[0]) - resting)[:, 0] / _START_K
        found[stage, :, 0, 2] = resting[:, 0]
        for k in range(1, 1 + pairs):
            above, below = (_ends(of_stage, flat, sign * _START_V * unit[k]) - resting for sign in (1.0, -1.0))
            found[stage, :, k, 0] = (above - below)[:, 0] / (2.0 * _START_V)
            found[stage, :, k, 1] = (above + below)[:, 0] / (2.0 * _START_V**2)
            found[stage, :, k, 2] = (above - below)[:, k] / (2.0 * _START_V)
            found[stage, :, k, 3] = resting[:, k]
    return found.reshape(stages, *currents.shape, 1 + pairs, _FOUR)


def _only(grid: Grid, stage: int) -> Grid:
    """Return the grid of one stage."""
    pieces = grid.stage == stage
    of_piece = ("charge_as", "open_v", "entropic", "warming", "reversible", "series_ohm", "cubic_ohm", "conductance")
    kept = {name: getattr(grid, name)[pieces] for name in (*of_piece, "drift")}
    return grid._replace(stage=np.zeros(pieces.sum(), dtype=np.int64), **kept)


def _ends(of_stage: Grid, currents: Array, start: Array) -> Array:
    """Return rise and voltages of the pairs at the end of a stage that begins with some, (n, 1 + pairs)."""
    state = np.tile(start, (len(currents), 1))
    pieces = np.empty((len(currents), len(of_stage.stage), FOUND))
    charge_stages(of_stage, currents[:, None], np.zeros((4, ORDER + 2)), state, pieces)
    return state


def _error(grid: Grid, maps: Maps) -> float:
    """Return how far the polynomials are off halfway between their nodes, over the largest value of each function."""
    nodes = chebyshev.chebpts1(_TERMS)
    between = 0.5 * (nodes[1:] + nodes[:-1])
    exact = _functions(grid, _places(maps.low_a, maps.high_a, maps.table.shape[1], between))
    powers = np.vander(between, _TERMS, increasing=True)
    away = np.abs(np.einsum("mp,stqpf->stmqf", powers, maps.table) - exact).max(axis=(0, 1, 2))
    size = np.abs(exact).max(axis=(0, 1, 2))
    return float(np.max(np.divide(away, size, out=np.zeros_like(away), where=size > 0.0)))


def never_limited(grid: Grid, currents: Currents, voltage_v: float, temperature_k: float) -> bool:
    """Return whether no currents of the range, however they follow each other, reach a limit."""
    largest_v, rise_k = largest(grid, currents)
    return largest_v < voltage_v and grid.ambient_k + rise_k < temperature_k


def largest(grid: Grid, currents: Currents) -> tuple[float, float]:
    """Return bounds of the voltage [V] and of the temperature rise [K], in size.

    The voltage of a pair never passes current times resistance, and its heat is at most what it takes up. Cooling,
    which brings a rise nearer to zero, is left out.
    """
    pairs_ohm = np.divide(1.0, grid.conductance, out=np.zeros_like(grid.conductance), where=grid.conductance > 0.0)
    relaxing_ohm = pairs_ohm.max(axis=(0, 2), initial=0.0).sum()
    piece_v = _MARGIN * currents.high * (grid.series_ohm.max(axis=1) + relaxing_ohm)
    heating_k = grid.cells / grid.heat_capacity_j_k * grid.charge_as * piece_v
    growth = np.prod(np.maximum(grid.warming.max(axis=1), 1.0))
    rise_k = float(growth * np.sum(heating_k + _MARGIN * np.abs(grid.reversible).max(axis=1)))
    entropic_v = _MARGIN * np.abs(grid.entropic).max() * rise_k
    return float(grid.cells * (np.max(grid.open_v.max(axis=1) + piece_v) + entropic_v)), rise_k
