"""The circuit of one cell as the kernels take it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.cell.curves import (
    ARRHENIUS,
    CURVE_FIELDS,
    FACTOR_FIELDS,
    FACTORS,
    compile_curves,
    factor_and_slope,
    integral,
    value_and_slope,
)
from pipeline.cell.records import Arrhenius, Battery, SideReaction, Warmth
from pipeline.jit import inlined, kernel, new_record

GAS_CONSTANT = 8.314462618
FARADAY = 96485.33212
THERMAL_V_PER_K = GAS_CONSTANT / FARADAY
REFERENCE_K = 298.15
ZERO_CELSIUS_K = 273.15

# Rows of the bank of curves; the pairs follow.
OPEN_CIRCUIT, ENTROPIC, SERIES, EXCHANGE, FIRST_PAIR = range(5)


MOST_RELAXATIONS = 8
CELL = np.dtype(
    [
        ("cells", np.float64),
        ("charge_as", np.float64),
        ("per_as", np.float64),
        ("pairs", np.int64),
        ("acceptance", np.int64),
        ("recombination", np.int64),
        ("relaxations", np.int64),
        ("tau_s", np.float64, (MOST_RELAXATIONS,)),
        ("acceptance_ohm", np.float64),
        ("transfer", np.int64),
        ("side", np.int64),
        ("side_a", np.float64),
        ("side_reference_v", np.float64),
        ("side_scale_v", np.float64),
        ("side_scale_v_per_k", np.float64),
        ("side_linear_per_k", np.float64),
        ("side_arrhenius_k", np.float64),
        ("side_reference_k", np.float64),
        ("gas_v", np.float64),
        ("hysteresis", np.int64),
        ("hysteresis_v", np.float64),
        ("hysteresis_start_v", np.float64),
        ("hysteresis_per_depth", np.float64),
        ("thermoneutral", np.int64),
        ("thermoneutral_v", np.float64),
        ("heat_capacity_j_k", np.float64),
        ("thermal_resistance_k_w", np.float64),
        *CURVE_FIELDS,
        *FACTOR_FIELDS,
    ],
    align=True,
)
"""One cell of the battery, scaled; `relaxations` counts pairs, acceptance pair and recombination, in that order."""

Cell = Any


def compile_cell(battery: Battery) -> Cell:
    """Return the kernel's form of a battery, a record of `CELL`, with `scaled_to_capacity_ah` applied.

    `k` cells in parallel multiply charge, exchange and side current and heat capacity by k and divide every resistance.
    """
    k = battery.scale
    cell = new_record(CELL)
    transfer, acceptance, side = battery.charge_transfer, battery.acceptance, battery.side_reaction
    pairs = list(battery.pairs.values())
    compile_curves(
        cell,
        [
            battery.open_circuit_voltage_v,
            battery.entropic_coefficient_v_k,
            battery.series_resistance_ohm,
            transfer.exchange_current_a if transfer else 1.0,
            *(pair.resistance_ohm for pair in pairs),
        ],
        [1.0, 1.0, 1.0 / k, k, *(1.0 / k for _ in pairs)],
    )
    compile_factors(cell, battery.warmths)
    tau = [pair.time_constant_s for pair in pairs]
    if acceptance:
        tau.append(acceptance.time_constant_s)
        cell["acceptance"], cell["acceptance_ohm"] = 1, acceptance.resistance_ohm / k
    if side:
        _compile_side(cell, side, k)
        if cell["recombination"]:
            tau.append(side.recombination_time_constant_s)
    cell["cells"], cell["charge_as"] = battery.cells_in_series, 3600.0 * battery.capacity_ah * k
    cell["per_as"] = 1.0 / cell["charge_as"]
    cell["pairs"], cell["relaxations"], cell["transfer"] = len(pairs), len(tau), transfer is not None
    cell["tau_s"][:] = 1.0
    cell["tau_s"][: len(tau)] = tau
    if battery.hysteresis is not None:
        cell["hysteresis"], cell["hysteresis_v"] = 1, battery.hysteresis.amplitude_v
        cell["hysteresis_start_v"] = battery.hysteresis.initial_share * battery.hysteresis.amplitude_v
        cell["hysteresis_per_depth"] = battery.hysteresis.rate_per_ah * battery.capacity_ah
    if battery.thermoneutral_voltage_v is not None:
        cell["thermoneutral"], cell["thermoneutral_v"] = 1, battery.thermoneutral_voltage_v
    cell["heat_capacity_j_k"] = battery.thermal.heat_capacity_j_k * k
    cell["thermal_resistance_k_w"] = battery.thermal.resistance_k_w / k
    return cell


def compile_factors(bank: Any, warmths: Sequence[Warmth | None]) -> None:
    """Write the factors of resistances into a record with `FACTOR_FIELDS`, in the order of their index."""
    for row, warmth in enumerate(warmths):
        if warmth is None:
            continue
        bank["warming"] = 1
        if isinstance(warmth, Arrhenius):
            bank["factor_kind"][row] = ARRHENIUS
            bank["factor_energy_k"][row] = warmth.activation_energy_j_mol / GAS_CONSTANT
            bank["factor_reference_k"][row] = warmth.reference_temperature_c + ZERO_CELSIUS_K
            continue
        from scipy.interpolate import PchipInterpolator

        knots = np.array(warmth.temperature_c) + ZERO_CELSIUS_K
        cubic = PchipInterpolator(knots, np.array(warmth.factor))
        bank["factor_kind"][row], bank["factor_pieces"][row] = FACTORS, len(knots) - 1
        bank["factor_knots_k"][row, : len(knots)] = knots
        bank["factor_coefficients"][row, : len(knots) - 1] = cubic.c[::-1].T


def _compile_side(cell: Cell, side: SideReaction, k: float) -> None:
    cell["side"], cell["side_a"] = 1, k * side.current_a
    cell["side_reference_v"] = side.reference_voltage_v
    cell["side_scale_v"] = side.voltage_scale_v or 0.0
    cell["side_scale_v_per_k"] = THERMAL_V_PER_K * (side.thermal_voltages or 0.0)
    cell["side_linear_per_k"] = side.temperature_coefficient_per_k
    cell["side_arrhenius_k"] = side.activation_energy_j_mol / GAS_CONSTANT
    cell["side_reference_k"] = side.reference_temperature_c + ZERO_CELSIUS_K
    if side.recombination_time_constant_s > 0:
        cell["recombination"], cell["gas_v"] = 1, side.gas_voltage_v


@inlined
def side_exponent(cell: Cell, node_v: float, temperature_k: float) -> tuple[float, float]:
    """Return the exponent of the side current and the voltage that raises it by one [V]."""
    scale = cell.side_scale_v + cell.side_scale_v_per_k * temperature_k
    above = temperature_k - cell.side_reference_k
    warmth = above * (cell.side_linear_per_k + cell.side_arrhenius_k / (temperature_k * cell.side_reference_k))
    return (node_v - cell.side_reference_v) / scale + warmth, scale


@inlined
def side_current(cell: Cell, node_v: float, temperature_k: float) -> tuple[float, float]:
    """Return the side current of a cell [A] and its slope with voltage [A/V].

    The exponent is continued by a straight line above 300, where only a failing iteration gets.
    """
    if cell.side == 0:
        return 0.0, 0.0
    exponent, scale = side_exponent(cell, node_v, temperature_k)
    current = cell.side_a * math.exp(min(exponent, 300.0))
    return current * (1.0 + max(exponent - 300.0, 0.0)), current / scale


@inlined
def hysteresis_at(cell: Cell, before_v: float, moved: float) -> tuple[float, float]:
    """Return the hysteresis after 1 - SOC has moved one way, and its slope with 1 - SOC [V].

    Arguments
    ---------
    before_v : its value before [V].
    moved : change of 1 - SOC, negative when charging [1].
    """
    goal = cell.hysteresis_v if moved < 0.0 else 0.0
    left = (goal - before_v) * math.exp(-cell.hysteresis_per_depth * abs(moved))
    return goal - left, -cell.hysteresis_per_depth * abs(left)


@kernel
def pair_ohm(cell: Cell, k: int, x: float, temperature_k: float) -> float:
    """Return the resistance of pair k of one cell, the acceptance pair being the last [ohm]."""
    resistance = cell.acceptance_ohm / x if k == cell.pairs else value_and_slope(cell, FIRST_PAIR + k, x)[0]
    return float(resistance * factor_and_slope(cell, 1 + k, temperature_k)[0])


@kernel
def series_ohm(cell: Cell, x: float, temperature_k: float) -> float:
    """Return the series resistance of one cell [ohm]."""
    return float(value_and_slope(cell, SERIES, x)[0] * factor_and_slope(cell, 0, temperature_k)[0])


@kernel
def enthalpy(cell: Cell, x: float) -> float:
    """Return the chemical energy stored in one cell at x = 1 - SOC, up to a constant [J].

    Its slope with charge is U - T dU/dT, which no temperature enters, or the measured thermoneutral voltage.
    """
    if cell.thermoneutral == 1:
        return float(-cell.charge_as * cell.thermoneutral_v * x)
    free = integral(cell, OPEN_CIRCUIT, x)
    return float(cell.charge_as * (free - REFERENCE_K * integral(cell, ENTROPIC, x)))
