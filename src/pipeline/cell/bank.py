"""Many batteries in the kernels' form at once, bit for bit what `compile_cell` makes of each of them."""

from __future__ import annotations

import mmap
from collections.abc import Sequence
from functools import lru_cache
from itertools import zip_longest
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    CELL,
    ENTROPIC,
    EXCHANGE,
    FIRST_PAIR,
    MOST_RELAXATIONS,
    OPEN_CIRCUIT,
    SERIES,
    THERMAL_V_PER_K,
    ZERO_CELSIUS_K,
    compile_factors,
)
from pipeline.cell.circuit import GAS_CONSTANT as R
from pipeline.cell.curves import (
    CONSTANT,
    CURVE_FIELDS,
    INVERSE,
    LOGARITHM,
    POLYNOMIAL,
    ROOT,
    SHEPHERD,
    TABLE,
    compile_curves,
)
from pipeline.cell.records import (
    Acceptance,
    Battery,
    ChargeTransfer,
    Curve,
    Hysteresis,
    Inverse,
    Logarithm,
    Pair,
    Polynomial,
    Root,
    Shepherd,
    SideReaction,
    Tabulated,
    Thermal,
    Warmth,
)
from pipeline.jit import new_record

_CURVES = np.dtype(CURVE_FIELDS, align=True)
_MOST_TABLES = 64
_PRIVATE = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_PRIVATE") else {}
# What of a cell only tables write and read, of curves and of factors; the latter lie at the end.
_TABLES_FROM, _TABLES_TO, _FACTORS_FROM = (CELL.fields[name][1] for name in ("knots", "warming", "factor_knots_k"))  # type: ignore[index]


def new_room(count: int) -> NDArray[Any]:
    """Return room for so many cells, in pages that nobody has to clear: a cell is mostly room for tables it has not."""
    octets = mmap.mmap(-1, max(count, 1) * CELL.itemsize, **_PRIVATE)
    return np.frombuffer(octets, dtype=np.dtype((np.record, CELL)), count=count)


class _Parts(NamedTuple):
    """The parts of batteries, a column each."""

    cells_in_series: tuple[int, ...]
    capacity_ah: tuple[float, ...]
    in_use_ah: tuple[float | None, ...]
    open_circuit: tuple[Curve, ...]
    entropic: tuple[Curve, ...]
    series: tuple[Curve, ...]
    series_warmth: tuple[Warmth | None, ...]
    pairs: tuple[dict[str, Pair], ...]
    acceptance: tuple[Acceptance | None, ...]
    transfer: tuple[ChargeTransfer | None, ...]
    side: tuple[SideReaction | None, ...]
    hysteresis: tuple[Hysteresis | None, ...]
    thermoneutral_v: tuple[float | None, ...]
    thermal: tuple[Thermal, ...]


_OF_BATTERY = attrgetter(
    "cells_in_series",
    "capacity_ah",
    "scaled_to_capacity_ah",
    "open_circuit_voltage_v",
    "entropic_coefficient_v_k",
    "series_resistance_ohm",
    "series_resistance_temperature",
    "pairs",
    "acceptance",
    "charge_transfer",
    "side_reaction",
    "hysteresis",
    "thermoneutral_voltage_v",
    "thermal",
)
_OF_PAIR = attrgetter("time_constant_s", "resistance_ohm", "resistance_temperature")
_OF_THERMAL = attrgetter("heat_capacity_j_k", "resistance_k_w")


def compile_cells(batteries: Sequence[Battery], room: NDArray[Any] | None = None) -> NDArray[Any]:
    """Return the kernels' form of batteries, an array of `CELL`, filled column by column.

    Arguments
    ---------
    batteries : of any kind each.
    room : of `new_room`, written over from its begin; what a table left there that is none any more is not cleared.
    """
    cells = new_room(len(batteries)) if room is None else room[: len(batteries)]
    if not batteries:
        return cells
    columns = cells.view(CELL)
    octets = cells.view(np.uint8).reshape(len(batteries), CELL.itemsize)
    octets[:, :_TABLES_FROM] = 0
    octets[:, _TABLES_TO:_FACTORS_FROM] = 0
    parts = _Parts(*zip(*map(_OF_BATTERY, batteries), strict=True))
    ratios = zip(parts.in_use_ah, parts.capacity_ah, strict=True)
    scale = np.array([1.0 if in_use is None else in_use / own for in_use, own in ratios])
    _fill_scalars(columns, parts, scale)
    tau_s, relaxations = np.ones((len(batteries), MOST_RELAXATIONS)), np.array([len(pairs) for pairs in parts.pairs])
    everyone = np.arange(len(batteries))
    _fill_curve(columns, everyone, OPEN_CIRCUIT, parts.open_circuit, np.ones(len(batteries)))
    _fill_curve(columns, everyone, ENTROPIC, parts.entropic, np.ones(len(batteries)))
    _fill_curve(columns, everyone, SERIES, parts.series, 1.0 / scale)
    exchange = [1.0 if one is None else one.exchange_current_a for one in parts.transfer]
    _fill_curve(columns, everyone, EXCHANGE, exchange, scale)
    warm = set(_given(parts.series_warmth)) | {n for n in _given(parts.acceptance) if batteries[n].warmths[-1]}
    pairs = [tuple(own.values()) for own in parts.pairs]
    for k in range(int(relaxations.max())):
        own = np.flatnonzero(relaxations > k)
        lag_s, resistance, warmth = zip(*[_OF_PAIR(pairs[n][k]) for n in own.tolist()], strict=True)
        tau_s[own, k] = lag_s
        _fill_curve(columns, own, FIRST_PAIR + k, resistance, 1.0 / scale[own])
        warm |= set(own[_given(warmth)].tolist())
    for column in ("acceptance", "recombination"):
        # Behind the pairs, in this order.
        own = np.flatnonzero(columns[column] == 1)
        lags = _acceptance_s if column == "acceptance" else _recombination_s
        tau_s[own, relaxations[own]] = [lags(parts, n) for n in own.tolist()]
        relaxations[own] += 1
    columns["tau_s"], columns["relaxations"] = tau_s, relaxations
    for row in warm:
        compile_factors(columns[row], batteries[row].warmths)
    return cells


def _given(parts: Sequence[object]) -> list[int]:
    """Return the places of what is not None."""
    return [n for n, part in enumerate(parts) if part is not None]


def _acceptance_s(parts: _Parts, n: int) -> float:
    return parts.acceptance[n].time_constant_s  # type: ignore[union-attr]


def _recombination_s(parts: _Parts, n: int) -> float:
    return parts.side[n].recombination_time_constant_s  # type: ignore[union-attr]


def _fill_scalars(columns: NDArray[Any], parts: _Parts, scale: NDArray[np.float64]) -> None:
    columns["cells"] = parts.cells_in_series
    columns["charge_as"] = 3600.0 * np.array(parts.capacity_ah) * scale
    columns["per_as"] = 1.0 / columns["charge_as"]
    columns["pairs"] = [len(pairs) for pairs in parts.pairs]
    columns["transfer"] = [transfer is not None for transfer in parts.transfer]
    heat_capacity_j_k, resistance_k_w = np.array([_OF_THERMAL(one) for one in parts.thermal]).T
    columns["heat_capacity_j_k"] = heat_capacity_j_k * scale
    columns["thermal_resistance_k_w"] = resistance_k_w / scale
    if own := _given(parts.acceptance):
        columns["acceptance"][own] = 1
        ohm = np.array([parts.acceptance[n].resistance_ohm for n in own])  # type: ignore[union-attr]
        columns["acceptance_ohm"][own] = ohm / scale[own]
    if own := _given(parts.side):
        sides = [_side(parts.side[n], k) for n, k in zip(own, scale[own].tolist(), strict=True)]  # type: ignore[arg-type]
        for name in sides[0]:
            columns[name][own] = [side[name] for side in sides]
    if own := _given(parts.hysteresis):
        zone = np.array([_OF_HYSTERESIS(parts.hysteresis[n]) for n in own])
        columns["hysteresis"][own], columns["hysteresis_v"][own] = 1, zone[:, 0]
        columns["hysteresis_start_v"][own] = zone[:, 1] * zone[:, 0]
        columns["hysteresis_per_depth"][own] = zone[:, 2] * np.array(parts.capacity_ah)[own]
    if own := _given(parts.thermoneutral_v):
        columns["thermoneutral"][own] = 1
        columns["thermoneutral_v"][own] = [parts.thermoneutral_v[n] for n in own]


_OF_HYSTERESIS = attrgetter("amplitude_v", "initial_share", "rate_per_ah")


def _side(side: SideReaction, k: float) -> dict[str, float]:
    recombines = side.recombination_time_constant_s > 0
    return {
        "side": 1,
        "side_a": k * side.current_a,
        "side_reference_v": side.reference_voltage_v,
        "side_scale_v": side.voltage_scale_v or 0.0,
        "side_scale_v_per_k": THERMAL_V_PER_K * (side.thermal_voltages or 0.0),
        "side_linear_per_k": side.temperature_coefficient_per_k,
        "side_arrhenius_k": side.activation_energy_j_mol / R,
        "side_reference_k": side.reference_temperature_c + ZERO_CELSIUS_K,
        "recombination": recombines,
        "gas_v": side.gas_voltage_v if recombines else 0.0,
    }


# Of each shape: its number, what a battery's factor multiplies, what it leaves.
_SHAPES: dict[type, tuple[int, tuple[str, ...], tuple[str, ...]]] = {
    Logarithm: (LOGARITHM, ("constant", "factor"), ("soc_offset", "depth_offset")),
    Root: (ROOT, ("factor",), ("soc_offset",)),
    Shepherd: (SHEPHERD, ("full_v", "polarisation_v"), ()),
    Inverse: (INVERSE, ("factor",), ("depth_offset",)),
}


def _fill_curve(
    columns: NDArray[Any],
    batteries: NDArray[np.int64],
    row: int,
    curves: Sequence[Curve],
    factor: NDArray[np.float64],
) -> None:
    """Write the curve of a row for each of some batteries, those of a shape together."""
    shapes = list(map(type, curves))
    for shape in dict.fromkeys(shapes):
        own = [n for n, found in enumerate(shapes) if found is shape]
        alike: list[Any] = [curves[n] for n in own]
        at, factors = batteries[own], factor[own]
        if shape is Tabulated:
            _fill_tables(columns, at.tolist(), row, alike, factors.tolist())
        elif shape is Polynomial:
            terms = [curve.polynomial for curve in alike]
            values = np.array(list(zip_longest(*terms, fillvalue=0.0)), dtype=np.float64)
            columns["kind"][at, row] = np.where([len(one) > 1 for one in terms], POLYNOMIAL, CONSTANT)
            columns["parameters"][at, row, : len(values)] = (factors * values).T
        elif shape in _SHAPES:
            number, scaled, left = _SHAPES[shape]
            values = np.array([[getattr(curve, name) for name in (*scaled, *left)] for curve in alike], np.float64)
            values[:, : len(scaled)] *= factors[:, None]
            columns["kind"][at, row], columns["parameters"][at, row, : values.shape[1]] = number, values
        else:
            columns["kind"][at, row], columns["parameters"][at, row, 0] = (
                CONSTANT,
                factors * np.array(alike, np.float64),
            )


def _fill_tables(
    columns: NDArray[Any], batteries: Sequence[int], row: int, curves: Sequence[Tabulated], factors: Sequence[float]
) -> None:
    for n, curve, factor in zip(batteries, curves, factors, strict=True):
        pieces, knots, coefficients = _table(tuple(curve.soc), tuple(curve.value), curve.scale, factor)
        columns["kind"][n, row], columns["pieces"][n, row] = TABLE, pieces
        columns["knots"][n, row, :pieces], columns["coefficients"][n, row, :pieces] = knots, coefficients


@lru_cache(maxsize=_MOST_TABLES)
def _table(
    soc: tuple[float, ...], value: tuple[float, ...], scale: float, factor: float
) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Return pieces, knots and coefficients of a table, once for all batteries that share it."""
    bank = new_record(_CURVES)
    compile_curves(bank, [Tabulated(soc=list(soc), value=list(value), scale=scale)], [factor])
    pieces = int(bank["pieces"][0])
    return pieces, bank["knots"][0, :pieces].copy(), bank["coefficients"][0, :pieces].copy()
