"""Incremental conductance: at maximum power dI/dV = -I/V; left of it more, right of it less.

Hussein, Muta, Hoshino and Osakada, IEE Proc. Gener. Transm. Distrib. 142 (1995) 59, DOI 10.1049/ip-gtd:19951577.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.algorithms.moves import BEFORE, BEFORE_V, BEGUN, cut, direction_by_slope, keep
from pipeline.tracker.records import IncrementalConductance, Scales, first_duty

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
    if memory[BEGUN] != 0.0:
        changes = voltage - memory[BEFORE_V], current - memory[BEFORE]
        direction = direction_by_slope(voltage, current, changes[0], changes[1], own[1])
    asked = own[2] if cut(memory, duty) else duty + direction * own[0]
    return keep(memory, voltage, current, 1.0, asked)
