"""Incremental conductance: at maximum power dI/dV = -I/V; left of it more, right of it less.

Hussein, Muta, Hoshino and Osakada, IEE Proc. Gener. Transm. Distrib. 142 (1995) 59, DOI 10.1049/ip-gtd:19951577.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.records import IncrementalConductance
from pipeline.tracker.scales import Scales, first_duty

Array = NDArray[np.float64]


def numbers(settings: IncrementalConductance, scales: Scales) -> list[float]:
    """Return the step of the duty, the tolerance, and the duty to begin with."""
    return [settings.duty_step, settings.tolerance, first_duty(settings, scales)]


@inlined
def decide(voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    """Return the next duty.

    At a limit of the duty it has lost its way, as light too faint to be measured makes it do, and begins anew.

    Arguments
    ---------
    voltage, current : as measured [V], [A].
    duty : the duty they were measured at.
    memory : voltage and current of the period before, 1 once there are some, the duty asked for; zeros at first.
    own : `numbers`.
    """
    direction = 1.0
    if memory[2] != 0.0:
        direction = direction_of(voltage, current, voltage - memory[0], current - memory[1], own[1])
    asked = duty + direction * own[0]
    if memory[2] != 0.0 and duty != memory[3]:
        asked = own[2]
    memory[0], memory[1], memory[2], memory[3] = voltage, current, 1.0, asked
    return float(asked)


@inlined
def direction_of(
    voltage: float, current: float, voltage_change: float, current_change: float, tolerance: float
) -> float:
    """Return where the duty must go: 1 up, to a lower voltage; -1 down; 0 at maximum power."""
    if current <= 0.0:
        return 1.0  # nothing flows yet: draw more
    if voltage_change == 0.0:
        # The light alone has changed: more of it asks for a higher voltage.
        return -1.0 if current_change > 0.0 else 1.0 if current_change < 0.0 else 0.0
    difference = current_change / voltage_change * voltage + current
    if abs(difference) <= tolerance * current:
        return 0.0
    return -1.0 if difference > 0.0 else 1.0
