"""Incremental conductance with a step in proportion to |dP/dV|, up to a largest step.

Liu, Duan, Liu, Liu and Kang, IEEE Trans. Ind. Electron. 55 (2008) 2622, DOI 10.1109/TIE.2008.920550.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.algorithms.moves import BEFORE, BEFORE_V, BEGUN, cut, direction_by_slope, keep
from pipeline.tracker.records import Scales, VariableStep, first_duty

Array = NDArray[np.float64]


def numbers(settings: VariableStep, scales: Scales) -> list[float]:
    """Return the step of the duty over |dP/dV| [1/A], largest step, duty to begin with."""
    step_per_a = settings.scaling / scales.short_circuit_current_a
    return [step_per_a, settings.most_duty_step, first_duty(settings, scales)]


@inlined
def decide(voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    """Return the next duty; at a limit of the duty it begins anew.

    Arguments
    ---------
    voltage, current : as measured [V], [A].
    duty : the duty they were measured at.
    memory : voltage, current and step of the period before, the duty asked for; zeros at first.
    own : `numbers`.
    """
    if memory[BEGUN] == 0.0 or current <= 0.0:
        step, direction = own[1], 1.0
    else:
        voltage_change, current_change = voltage - memory[BEFORE_V], current - memory[BEFORE]
        direction = direction_by_slope(voltage, current, voltage_change, current_change, 0.0)
        step = memory[BEGUN]  # with the voltage unchanged there is no slope to take a new one from
        if voltage_change != 0.0:
            step = min(own[0] * abs(current + voltage * current_change / voltage_change), own[1])
    asked = own[2] if cut(memory, duty) else duty + direction * step
    return keep(memory, voltage, current, max(step, 1e-9), asked)
