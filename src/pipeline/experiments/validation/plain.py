"""A cell so plain that its charge can be written down, and charges of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery, Pair, Polynomial, Thermal
from pipeline.charge.protocol import C_RATE
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode, Window
from pipeline.charge.simulate import BENCH, Charge, simulate
from pipeline.experiments.validation.records import Conditions

CELLS, CAPACITY_AH, OHM, HEAT_CAPACITY_J_K = 2, 1.0, 0.05, 100.0
FULL_V, SLOPE_V = 2.0, 0.5
START_SOC, AMBIENT_C = 0.1, 25.0
INSULATED_K_W = 1e12
PERIOD_S, SHARE = 0.125, 0.875
"""Of the pulses, both exact in binary."""


def battery(
    pair: Pair | None = None,
    cooling_k_w: float = INSULATED_K_W,
    slope_v: float = SLOPE_V,
    capacity_ah: float = CAPACITY_AH,
) -> Battery:
    """Return the cell: a linear open-circuit voltage, a resistance, perhaps a pair, a heat capacity.

    Arguments
    ---------
    cooling_k_w : thermal resistance to the ambient [K/W].
    slope_v : rise of the open-circuit voltage from empty to full [V].
    """
    return Battery(
        name="plain",
        title="Plain",
        cells_in_series=CELLS,
        capacity_ah=capacity_ah,
        open_circuit_voltage_v=Polynomial(polynomial=[FULL_V, -slope_v]),
        series_resistance_ohm=OHM,
        pairs={} if pair is None else {"only": pair},
        thermal=Thermal(heat_capacity_j_k=HEAT_CAPACITY_J_K, resistance_k_w=cooling_k_w),
    )


def constant(current_a: float, seconds: float) -> Mode:
    """Return a constant current for so long."""
    return _mode({"constant_current": {"current_a": current_a}}, seconds)


def pulsed(current_a: float, seconds: float, limit_v: float | None = None) -> Mode:
    """Return pulses of a constant current for so long, under a voltage limit if there is one."""
    pulse = {"charge_a": current_a, "charge_share": SHARE, "frequency_hz": 1.0 / PERIOD_S}
    return _mode({"pulse": pulse} | ({} if limit_v is None else {"limit": {"voltage_v": limit_v}}), seconds)


def held(voltage_v: float, seconds: float) -> Mode:
    """Return a voltage held for so long, by any current."""
    return _mode({"constant_voltage": {"voltage_v": voltage_v, "max_current_a": 100.0}}, seconds)


def charged(
    cell: Battery, mode: Mode, driver: str, interval_s: float, window: Window | None = None, **engine: Any
) -> Charge:
    """Charge from a bench supply by one driver and return what came of it.

    Arguments
    ---------
    interval_s : interval of the trace [s].
    window : what is kept at full resolution.
    engine : settings of the engine beside its driver.
    """
    settings = ChargeSettings(
        initial_soc=START_SOC,
        ambient_c=AMBIENT_C,
        sample_interval_s=interval_s,
        windows=[] if window is None else [window],
    )
    return simulate(cell, mode, BENCH, settings, EngineSettings.model_validate({"driver": driver} | engine))


def pulsed_rise(start: float, settled: float, lag_s: float, periods: NDArray[np.float64] | float) -> Any:
    """Return what relaxes towards `settled` in every pulse and towards 0 in every pause, at the end of periods.

    Arguments
    ---------
    start : value at the start.
    lag_s : time constant [s].
    periods : how many, whole.
    """
    pulse = -math.expm1(-SHARE * PERIOD_S / lag_s) * math.exp(-(1.0 - SHARE) * PERIOD_S / lag_s)
    gone = -np.expm1(-np.asarray(periods) * PERIOD_S / lag_s)
    return start * (1.0 - gone) + settled * pulse * gone / -math.expm1(-PERIOD_S / lag_s)


def number(charge: Charge, quantity: str) -> float:
    """Return a number of a charge's summary, NaN where it has none."""
    found = next(row.value for row in charge.summary if row.quantity == quantity)
    return math.nan if found is None else found


def _mode(phase: dict[str, Any], seconds: float) -> Mode:
    return Mode.model_validate({"title": "plain", "phases": {"charge": phase}, "stop": {"elapsed_s": seconds}})


_CURRENTS = ("_a", C_RATE)


def suited(mode: Mode, battery: Battery, conditions: Conditions, bulk_s: float, duration_s: float) -> Mode:
    """Return a mode whose largest current and voltage are those of the conditions, shortened.

    Arguments
    ---------
    bulk_s, duration_s : length of phases that end by time, and of the whole charge [s].
    """
    sheet = mode.model_dump(mode="json", by_alias=True)
    capacity_ah = battery.capacity_in_use_ah
    factor = conditions.current_c_rate * capacity_ah / max(_currents(sheet, capacity_ah))
    sheet = _scaled(sheet, factor, conditions.voltage_v)
    for phase in sheet["phases"].values():
        if "elapsed_s" in phase.get("until", {}):
            phase["until"]["elapsed_s"] = bulk_s
    return Mode.model_validate(sheet | {"stop": {"elapsed_s": duration_s}})


def _currents(tree: Any, capacity_ah: float, name: str = "") -> list[float]:
    """Return every current of a sheet [A]."""
    if isinstance(tree, dict):
        return [one for key, value in tree.items() if key != "stop" for one in _currents(value, capacity_ah, key)]
    if isinstance(tree, list):
        return [one for value in tree for one in _currents(value, capacity_ah, name.removesuffix("s_a") + "_a")]
    if not isinstance(tree, float | int) or not name.endswith(_CURRENTS):
        return []
    return [tree * capacity_ah if name.endswith(C_RATE) else tree]


def _scaled(tree: Any, factor: float, voltage_v: float, name: str = "") -> Any:
    if isinstance(tree, dict):
        return {key: _scaled(value, factor, voltage_v, key) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_scaled(value, factor, voltage_v, name) for value in tree]
    if not isinstance(tree, float | int):
        return tree
    if name == "voltage_v":
        return voltage_v
    return factor * tree if name.endswith(_CURRENTS) else tree
