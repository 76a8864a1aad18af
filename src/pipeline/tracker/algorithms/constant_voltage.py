"""Constant voltage, the poor man's tracker: a share of the data sheet's open-circuit voltage, held all day."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.records import ConstantVoltage, Scales

Array = NDArray[np.float64]


def numbers(settings: ConstantVoltage, scales: Scales) -> list[float]:
    """Return the voltage to hold [V], and the duty that mends a volt [1/V]."""
    return [settings.voltage_share * scales.open_circuit_voltage_v, settings.gain / scales.bus_voltage_v]


@inlined
def decide(voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    """Return the next duty, which integrates the error; nothing is remembered but the duty itself."""
    return float(duty + own[1] * (voltage - own[0]))
