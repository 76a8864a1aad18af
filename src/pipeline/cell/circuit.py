"""The circuit of one cell as the kernels take it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.curves import Curves, compile_curves, integral
from pipeline.cell.records import Battery, SideReaction
from pipeline.jit import kernel

GAS_CONSTANT = 8.314462618
FARADAY = 96485.33212
THERMAL_V_PER_K = GAS_CONSTANT / FARADAY
REFERENCE_K = 298.15
ZERO_CELSIUS_K = 273.15

# Rows of the bank of curves; the pairs follow.
OPEN_CIRCUIT, ENTROPIC, SERIES, EXCHANGE, FIRST_PAIR = range(5)


class Cell(NamedTuple):
    """One cell of the battery, scaled; `relaxations` counts pairs, acceptance pair and recombination, in that order."""

    cells: float
    charge_as: float
    curves: Curves
    pairs: int
    acceptance: int
    recombination: int
    relaxations: int
    tau_s: NDArray[np.float64]
    acceptance_ohm: float
    transfer: int
    side: int
    side_a: float
    side_reference_v: float
    side_scale_v: float
    side_scale_v_per_k: float
    side_linear_per_k: float
    side_arrhenius_k: float
    side_reference_k: float
    gas_v: float
    thermoneutral: int
    thermoneutral_v: float
    heat_capacity_j_k: float
    thermal_resistance_k_w: float


def compile_cell(battery: Battery) -> Cell:
    """Return the kernel's form of a battery, with `scaled_to_capacity_ah` applied.

    `k` cells in parallel multiply charge, exchange and side current and heat capacity by k and divide every resistance.
    """
    k = battery.scale
    transfer = battery.charge_transfer
    pairs = list(battery.pairs.values())
    curves = compile_curves(
        [
            battery.open_circuit_voltage_v,
            battery.entropic_coefficient_v_k,
            battery.series_resistance_ohm,
            transfer.exchange_current_a if transfer else 1.0,
            *(pair.resistance_ohm for pair in pairs),
        ],
        [1.0, 1.0, 1.0 / k, k, *(1.0 / k for _ in pairs)],
    )
    side = battery.side_reaction
    tau = [pair.time_constant_s for pair in pairs]
    if battery.acceptance:
        tau.append(battery.acceptance.time_constant_s)
    lagging = side is not None and side.recombination_time_constant_s > 0
    if side is not None and lagging:
        tau.append(side.recombination_time_constant_s)
    return Cell(
        cells=float(battery.cells_in_series),
        charge_as=3600.0 * battery.capacity_ah * k,
        curves=curves,
        pairs=len(pairs),
        acceptance=int(battery.acceptance is not None),
        recombination=int(lagging),
        relaxations=len(tau),
        tau_s=np.array(tau, dtype=np.float64),
        acceptance_ohm=battery.acceptance.resistance_ohm / k if battery.acceptance else 0.0,
        transfer=int(transfer is not None),
        **_side(side, k),
        thermoneutral=int(battery.thermoneutral_voltage_v is not None),
        thermoneutral_v=battery.thermoneutral_voltage_v or 0.0,
        heat_capacity_j_k=battery.thermal.heat_capacity_j_k * k,
        thermal_resistance_k_w=battery.thermal.resistance_k_w / k,
    )


def _side(side: SideReaction | None, k: float) -> dict[str, float]:
    names = (
        "side",
        "side_a",
        "side_reference_v",
        "side_scale_v",
        "side_scale_v_per_k",
        "side_linear_per_k",
        "side_arrhenius_k",
        "side_reference_k",
        "gas_v",
    )
    if side is None:
        return dict.fromkeys(names, 0.0) | {"side": 0, "side_scale_v": 1.0, "side_reference_k": REFERENCE_K}
    values = (
        1,
        k * side.current_a,
        side.reference_voltage_v,
        side.voltage_scale_v or 0.0,
        THERMAL_V_PER_K * (side.thermal_voltages or 0.0),
        side.temperature_coefficient_per_k,
        side.activation_energy_j_mol / GAS_CONSTANT,
        side.reference_temperature_c + ZERO_CELSIUS_K,
        side.gas_voltage_v if side.recombination_time_constant_s > 0 else 0.0,
    )
    return dict(zip(names, values, strict=True))


@kernel
def side_current(cell: Cell, node_v: float, temperature_k: float) -> tuple[float, float]:
    """Return the side current of a cell [A] and its slope with voltage [A/V].

    The exponent is continued by a straight line above 300, where only a failing iteration gets.
    """
    if cell.side == 0:
        return 0.0, 0.0
    scale = cell.side_scale_v + cell.side_scale_v_per_k * temperature_k
    above = temperature_k - cell.side_reference_k
    warmth = above * (cell.side_linear_per_k + cell.side_arrhenius_k / (temperature_k * cell.side_reference_k))
    exponent = (node_v - cell.side_reference_v) / scale + warmth
    current = cell.side_a * math.exp(min(exponent, 300.0))
    return current * (1.0 + max(exponent - 300.0, 0.0)), current / scale


@kernel
def enthalpy(cell: Cell, x: float) -> float:
    """Return the chemical energy stored in one cell at x = 1 - SOC, up to a constant [J].

    Its slope with charge is U - T dU/dT, which no temperature enters, or the measured thermoneutral voltage.
    """
    if cell.thermoneutral == 1:
        return -cell.charge_as * cell.thermoneutral_v * x
    free = integral(cell.curves, OPEN_CIRCUIT, x)
    return cell.charge_as * (free - REFERENCE_K * integral(cell.curves, ENTROPIC, x))
