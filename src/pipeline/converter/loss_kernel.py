"""The averaged boost and buck converter with all losses, by load, compiled.

Duty and ripple follow from the volt-seconds of the inductor, resistances and forward voltages included; below the
boundary of continuous conduction a diode's current ends within the period. Erickson and Maksimovic, Fundamentals of
Power Electronics (2020), DOI 10.1007/978-3-030-43881-4, chapters 3, 4 and 5; core loss by Steinmetz.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined, kernel

Array = NDArray[np.float64]

(
    FREQUENCY, INDUCTANCE, WINDING, SWITCH, RECTIFIER, FORWARD, ESR, SYNCHRONOUS,
    TRANSITION, NODE, GATE, DRIVER, CORE, CORE_RIPPLE, CORE_FREQUENCY, RIPPLE_POWER, FREQUENCY_POWER, CONTROL,
) = range(18)  # fmt: skip
"""Places of a converter's numbers."""

COLUMNS = (
    "duty", "ripple_a", "switch_w", "rectifier_w", "winding_w", "capacitor_w", "switching_w", "core_w", "control_w",
)  # fmt: skip
"""What is found of each load: duty, inductor ripple, and losses by path."""
_FIRST_LOSS, _END = 2, len(COLUMNS)
_STEPS = 60
_SETTLED = 1e-12


@inlined
def _at_current(boosts: bool, parts: Array, source: float, sink: float, current: float, found: Array) -> float:
    """Fill in duty, ripple and losses at a mean inductor current; return the losses [W]."""
    switch, rectifier, winding, forward = parts[SWITCH], parts[RECTIFIER], parts[WINDING], parts[FORWARD]
    period, henry = 1.0 / parts[FREQUENCY], parts[INDUCTANCE]
    blocked = sink + forward if boosts else source + forward
    if boosts:
        duty = (blocked - source + current * (winding + rectifier)) / (blocked - current * (switch - rectifier))
        rising, falling = source - current * (switch + winding), blocked - source
    else:
        duty = (sink + forward + current * (winding + rectifier)) / (blocked - current * (switch - rectifier))
        rising, falling = source - sink - current * (switch + winding), sink + forward
    duty = min(max(duty, 0.0), 1.0)
    ripple, rest = max(rising, 0.0) * duty * period / henry, 1.0 - duty
    lowest = current - 0.5 * ripple
    if lowest < 0.0 and parts[SYNCHRONOUS] == 0.0 and rising > 0.0 and falling > 0.0:
        ratio = rising / falling
        duty = math.sqrt(2.0 * henry * max(current, 0.0) / (period * rising * (1.0 + ratio)))
        rest, ripple, lowest = duty * ratio, rising * duty * period / henry, 0.0
        square = ripple * ripple / 3.0
        carried = 0.5 * ripple * rest
    else:
        square = current * current + ripple * ripple / 12.0
        carried = current * rest
    output = carried if boosts else current
    into_output = square * rest if boosts else square * (duty + rest)
    found[0], found[1] = duty, ripple
    found[2] = switch * square * duty
    found[3] = rectifier * square * rest + forward * carried
    found[4] = winding * square * (duty + rest)
    found[5] = parts[ESR] * max(into_output - output * output, 0.0)
    edges = 0.5 * blocked * (max(lowest, 0.0) + lowest + ripple) * parts[TRANSITION]
    charged = 0.5 * parts[NODE] * blocked * blocked + parts[GATE] * parts[DRIVER]
    found[6] = (max(edges, 0.0) + charged) * parts[FREQUENCY]
    swing = (ripple / parts[CORE_RIPPLE]) ** parts[RIPPLE_POWER]
    found[7] = parts[CORE] * swing * (parts[FREQUENCY] / parts[CORE_FREQUENCY]) ** parts[FREQUENCY_POWER]
    found[8] = parts[CONTROL]
    total = 0.0
    for path in range(_FIRST_LOSS, _END):
        total += found[path]
    return total


@kernel
def fill_losses(boosts: bool, parts: Array, source: Array, sink: Array, power: Array, found: Array) -> None:
    """Fill in duty, ripple and losses of each load.

    Arguments
    ---------
    boosts : a boost converter, else a buck converter.
    parts : its numbers by place.
    source, sink : voltages at input and output [V], shape (n,).
    power : power at the input [W], shape (n,).
    found : the columns, filled in, shape (n, 9); where the power does not cover the losses, these are all of it.
    """
    for row in range(power.shape[0]):
        own = found[row]
        if boosts:
            _at_current(True, parts, source[row], sink[row], power[row] / source[row], own)
        else:
            current = power[row] / sink[row]
            for _ in range(_STEPS):
                lost = _at_current(False, parts, source[row], sink[row], current, own)
                following = max(power[row] - lost, 0.0) / sink[row]
                moved = abs(following - current)
                current = following
                if moved <= _SETTLED * (1.0 + current):
                    break
        total = 0.0
        for path in range(_FIRST_LOSS, _END):
            total += own[path]
        if total > power[row]:
            share = power[row] / total if total > 0.0 else 0.0
            for path in range(_FIRST_LOSS, _END):
                own[path] *= share
