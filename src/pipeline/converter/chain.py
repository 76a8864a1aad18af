"""The chain of powers from the panel to the battery's terminals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.efficiency import boost_efficiency, buck_efficiency
from pipeline.converter.records import Load, PowerChain

Columns = dict[str, NDArray[np.float64]]


def battery_power(
    time_s: ArrayLike,
    irradiance_w_m2: ArrayLike,
    cell_temperature_c: ArrayLike,
    panel_power_w: ArrayLike,
    chain: PowerChain,
    load: Load,
    panel_voltage_v: ArrayLike = np.nan,
) -> Columns:
    """Follow the panel's maximum power to the battery: bus, less the load, through the buck converter.

    Arguments
    ---------
    time_s : starts of the intervals over which everything is constant [s], shape (n,).
    irradiance_w_m2, cell_temperature_c : the weather in each interval [W/m2], [degC], shape (n,).
    panel_power_w : maximum power of the panel [W], shape (n,).
    chain : tracker, boost and buck.
    load : the master system, served first.
    panel_voltage_v : voltage at that power, which a boost converter of parts depends on [V], shape (n,).

    Returns
    -------
    The columns of SUPPLY, shape (n,) each; where the load takes all, the battery's power is 0.
    """
    panel = np.asarray(panel_power_w, dtype=float)
    boost = boost_efficiency(chain, panel_voltage_v, panel * chain.tracker_efficiency)
    bus = panel * chain.tracker_efficiency * boost
    left = np.maximum(0.0, bus - load.power_w)
    buck = buck_efficiency(chain, chain.nominal_battery_voltage_v, left)
    return {
        "time_s": np.asarray(time_s, dtype=float),
        "irradiance_w_m2": np.asarray(irradiance_w_m2, dtype=float),
        "cell_temperature_c": np.asarray(cell_temperature_c, dtype=float),
        "panel_power_w": panel,
        "bus_power_w": bus,
        "load_power_w": np.full_like(panel, load.power_w),
        "battery_power_w": left * buck,
        "buck_efficiency": buck,
        "boost_efficiency": boost,
    }


def unserved_load_w(supply: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the part of the load the bus cannot serve [W], shape (n,); above 0 the battery gets nothing."""
    return np.maximum(0.0, supply["load_power_w"] - supply["bus_power_w"])
