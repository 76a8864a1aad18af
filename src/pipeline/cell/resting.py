"""The voltage of a resting battery, from its record alone: nothing compiled, for checks before anything runs."""

from __future__ import annotations

import math

from pipeline.cell.records import Battery, Curve, Inverse, Logarithm, Polynomial, Root, Shepherd


def value_of(curve: Curve, soc: float) -> float:
    """Return a curve's value at a state of charge; a table is read by straight lines, near enough for a check."""
    depth = 1.0 - soc
    if isinstance(curve, float | int):
        return float(curve)
    if isinstance(curve, Polynomial):
        return sum(coefficient * depth**power for power, coefficient in enumerate(curve.polynomial))
    if isinstance(curve, Logarithm):
        above, below = soc + curve.soc_offset, depth + curve.depth_offset
        if above <= 0.0:
            return -math.copysign(math.inf, curve.factor)
        return curve.constant + curve.factor * math.log(above / below) if below > 0.0 else math.inf
    if isinstance(curve, Root):
        return curve.factor * math.sqrt(depth * (soc + curve.soc_offset))
    if isinstance(curve, Shepherd):
        return curve.full_v - curve.polarisation_v * depth / soc if soc > 0.0 else -math.inf
    if isinstance(curve, Inverse):
        return curve.factor / (depth + curve.depth_offset) if depth + curve.depth_offset > 0.0 else math.inf
    for n in range(1, len(curve.soc)):
        if soc <= curve.soc[n]:
            share = (soc - curve.soc[n - 1]) / (curve.soc[n] - curve.soc[n - 1])
            return curve.scale * (curve.value[n - 1] + share * (curve.value[n] - curve.value[n - 1]))
    return curve.scale * curve.value[-1]


def resting_voltage_v(battery: Battery, soc: float, temperature_c: float) -> float:
    """Return the open-circuit voltage of a battery [V].

    Arguments
    ---------
    soc : state of charge [1].
    temperature_c : temperature [degC].
    """
    entropic = value_of(battery.entropic_coefficient_v_k, soc) * (temperature_c - 25.0)
    return battery.cells_in_series * (value_of(battery.open_circuit_voltage_v, soc) + entropic)
