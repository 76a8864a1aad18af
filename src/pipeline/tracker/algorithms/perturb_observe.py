"""Perturb and observe: dP dV > 0 calls for a higher voltage, which a boost converter gives at a lower duty.

Femia, Petrone, Spagnuolo and Vitelli, IEEE Trans. Power Electron. 20 (2005) 963, DOI 10.1109/TPEL.2005.850975.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.algorithms.moves import BEFORE, BEFORE_V, BEGUN, cut, keep
from pipeline.tracker.records import PerturbObserve, Scales

Array = NDArray[np.float64]


def numbers(settings: PerturbObserve, scales: Scales) -> list[float]:
    """Return the step of the duty."""
    return [settings.duty_step]


@inlined
def decide(voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    """Return the next duty.

    Arguments
    ---------
    voltage, current : as measured [V], [A].
    duty : the duty they were measured at.
    memory : voltage and power of the period before, direction of the duty, the duty asked for; zeros at first.
    own : `numbers`.
    """
    power = voltage * current
    direction, power_change, voltage_change = memory[BEGUN], power - memory[BEFORE], voltage - memory[BEFORE_V]
    if direction == 0.0 or power <= 0.0:
        direction = 1.0  # nothing flows yet: draw more
    elif cut(memory, duty):
        direction = -direction  # the duty is at its limit
    elif power_change * voltage_change != 0.0:
        direction = -1.0 if power_change * voltage_change > 0.0 else 1.0
    return keep(memory, voltage, power, direction, duty + direction * own[0])
