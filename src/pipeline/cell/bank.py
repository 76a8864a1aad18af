"""Many batteries in the kernels' form at once, bit for bit what `compile_cell` makes of each of them."""

from __future__ import annotations

import mmap
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import CELL, MOST_RELAXATIONS, THERMAL_V_PER_K, ZERO_CELSIUS_K, compile_factors
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
    Battery,
    Curve,
    Inverse,
    Logarithm,
    Polynomial,
    Root,
    Shepherd,
    SideReaction,
    Tabulated,
)
from pipeline.jit import new_record

_CURVES = np.dtype(CURVE_FIELDS, align=True)
_MOST_TABLES = 64
_PRIVATE = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_PRIVATE") else {}
# What of a cell only tables write and read.
_TABLES_FROM, _TABLES_TO = CELL.fields["knots"][1], CELL.fields["warming"][1]  # type: ignore[index]


def new_room(count: int) -> NDArray[Any]:
    """Return room for so many cells, in pages that nobody has to clear: a cell is mostly room for tables it has not."""
    octets = mmap.mmap(-1, max(count, 1) * CELL.itemsize, **_PRIVATE)
    return np.frombuffer(octets, dtype=np.dtype((np.record, CELL)), count=count)


def compile_cells(batteries: Sequence[Battery], room: NDArray[Any] | None = None) -> NDArray[Any]:
    """Return the kernels' form of batteries, an array of `CELL`, filled column by column.

    Arguments
    ---------
    batteries : of any kind each.
    room : of `new_room`, written over from its begin; what a table left there that is none any more is not cleared.
    """
    cells = new_room(len(batteries)) if room is None else room[: len(batteries)]
    columns = cells.view(CELL)
    octets = cells.view(np.uint8).reshape(len(batteries), CELL.itemsize)
    octets[:, :_TABLES_FROM] = 0
    octets[:, _TABLES_TO:] = 0
    scale = np.array([battery.scale for battery in batteries])
    _fill_scalars(columns, batteries, scale)
    tau_s = np.ones((len(batteries), MOST_RELAXATIONS))
    lags = [_lags_s(battery) for battery in batteries]
    for row, battery in enumerate(batteries):
        tau_s[row, : len(lags[row])] = lags[row]
        if any(battery.warmths):
            compile_factors(columns[row], battery.warmths)
    columns["tau_s"], columns["relaxations"] = tau_s, [len(own) for own in lags]
    _fill_curves(columns, batteries, scale)
    return cells


def _lags_s(battery: Battery) -> list[float]:
    """Return the time constants in their order: pairs, acceptance pair, recombination."""
    tau = [pair.time_constant_s for pair in battery.pairs.values()]
    if battery.acceptance:
        tau.append(battery.acceptance.time_constant_s)
    if battery.side_reaction and battery.side_reaction.recombination_time_constant_s > 0:
        tau.append(battery.side_reaction.recombination_time_constant_s)
    return tau


def _fill_scalars(columns: NDArray[Any], batteries: Sequence[Battery], scale: NDArray[np.float64]) -> None:
    columns["cells"] = [battery.cells_in_series for battery in batteries]
    columns["charge_as"] = 3600.0 * np.array([battery.capacity_ah for battery in batteries]) * scale
    columns["per_as"] = 1.0 / columns["charge_as"]
    columns["pairs"] = [len(battery.pairs) for battery in batteries]
    columns["transfer"] = [battery.charge_transfer is not None for battery in batteries]
    columns["heat_capacity_j_k"] = np.array([battery.thermal.heat_capacity_j_k for battery in batteries]) * scale
    columns["thermal_resistance_k_w"] = np.array([battery.thermal.resistance_k_w for battery in batteries]) / scale
    for row, battery in enumerate(batteries):
        if battery.acceptance is not None:
            columns["acceptance"][row] = 1
            columns["acceptance_ohm"][row] = battery.acceptance.resistance_ohm / scale[row]
        if battery.side_reaction is not None:
            for name, value in _side(battery.side_reaction, float(scale[row])).items():
                columns[name][row] = value
        if battery.hysteresis is not None:
            columns["hysteresis"][row], columns["hysteresis_v"][row] = 1, battery.hysteresis.amplitude_v
            columns["hysteresis_start_v"][row] = battery.hysteresis.initial_share * battery.hysteresis.amplitude_v
            columns["hysteresis_per_depth"][row] = battery.hysteresis.rate_per_ah * battery.capacity_ah
        if battery.thermoneutral_voltage_v is not None:
            columns["thermoneutral"][row] = 1
            columns["thermoneutral_v"][row] = battery.thermoneutral_voltage_v


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


class _Entry(NamedTuple):
    battery: int
    row: int
    curve: Curve
    factor: float


def _entries(batteries: Sequence[Battery], scale: NDArray[np.float64]) -> Iterator[_Entry]:
    for n, battery in enumerate(batteries):
        k = float(scale[n])
        transfer = battery.charge_transfer
        yield _Entry(n, 0, battery.open_circuit_voltage_v, 1.0)
        yield _Entry(n, 1, battery.entropic_coefficient_v_k, 1.0)
        yield _Entry(n, 2, battery.series_resistance_ohm, 1.0 / k)
        yield _Entry(n, 3, transfer.exchange_current_a if transfer else 1.0, k)
        for row, pair in enumerate(battery.pairs.values(), 4):
            yield _Entry(n, row, pair.resistance_ohm, 1.0 / k)


def _fill_curves(columns: NDArray[Any], batteries: Sequence[Battery], scale: NDArray[np.float64]) -> None:
    """Write the curves of all batteries, those of a kind together."""
    of_kind: dict[type, list[_Entry]] = {}
    for entry in _entries(batteries, scale):
        of_kind.setdefault(type(entry.curve), []).append(entry)
    kind, parameters = columns["kind"], columns["parameters"]
    for shape, entries in of_kind.items():
        if shape is Tabulated:
            _fill_tables(columns, entries)
            continue
        at = [entry.battery for entry in entries], [entry.row for entry in entries]
        number, values = _KINDS[shape] if shape in _KINDS else _KINDS[float]
        made = np.zeros((len(entries), 4))
        for place, entry in enumerate(entries):
            row = values(entry.curve, entry.factor)
            made[place, : len(row)] = row
        kind[at] = number
        parameters[at] = made
        for entry in entries:
            if shape is Polynomial and len(entry.curve.polynomial) == 1:  # type: ignore[union-attr]
                kind[entry.battery, entry.row] = CONSTANT


_KINDS: dict[type, tuple[int, Any]] = {
    float: (CONSTANT, lambda c, f: (f * c,)),
    Polynomial: (POLYNOMIAL, lambda c, f: [f * one for one in c.polynomial]),
    Logarithm: (LOGARITHM, lambda c, f: (f * c.constant, f * c.factor, c.soc_offset, c.depth_offset)),
    Root: (ROOT, lambda c, f: (f * c.factor, c.soc_offset)),
    Shepherd: (SHEPHERD, lambda c, f: (f * c.full_v, f * c.polarisation_v)),
    Inverse: (INVERSE, lambda c, f: (f * c.factor, c.depth_offset)),
}


def _fill_tables(columns: NDArray[Any], entries: Sequence[_Entry]) -> None:
    for n, row, curve, factor in entries:
        assert isinstance(curve, Tabulated)
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
