"""The data sheet's values that a tracker's settings are relative to."""

from __future__ import annotations

from typing import NamedTuple

from pipeline.tracker.records import AnyTracker


class Scales(NamedTuple):
    """Open-circuit voltage and short-circuit current of all panels at 1000 W/m2 and 25 degC, and the bus voltage."""

    open_circuit_voltage_v: float
    short_circuit_current_a: float
    bus_voltage_v: float


def first_duty(tracker: AnyTracker, scales: Scales) -> float:
    """Return the duty at which a tracker begins: near its share of V_oc, the converter's losses left out."""
    duty = 1.0 - tracker.start_voltage_share * scales.open_circuit_voltage_v / scales.bus_voltage_v
    return min(max(duty, tracker.least_duty), tracker.most_duty)
