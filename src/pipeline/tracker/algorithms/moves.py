"""What the trackers that climb the hill share: which way is up, what is kept of a period, and what a limit asks for.

All remember voltage and what they compare, a third number that is zero before the first period, and the duty asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined

Array = NDArray[np.float64]

BEFORE_V, BEFORE, BEGUN, ASKED = range(4)
"""Places of the memory: voltage and power or current of the period before, whether there was one, the duty asked for.

In place of a plain one, `BEGUN` may hold what a tracker wants to know of that period beside: a direction, a step.
"""


@inlined
def cut(memory: Array, duty: float) -> bool:
    """Tell whether the duty asked for at the last period was cut at a limit."""
    return bool(memory[BEGUN] != 0.0 and duty != memory[ASKED])


@inlined
def keep(memory: Array, voltage: float, other: float, begun: float, asked: float) -> float:
    """Keep a period for the next one; return the duty that is asked for."""
    memory[BEFORE_V], memory[BEFORE], memory[BEGUN], memory[ASKED] = voltage, other, begun, asked
    return float(asked)


@inlined
def direction_by_slope(
    voltage: float, current: float, voltage_change: float, current_change: float, tolerance: float
) -> float:
    """Return where the duty must go by dI/dV and -I/V: 1 up, to a lower voltage; -1 down; 0 at maximum power."""
    if current <= 0.0:
        return 1.0  # nothing flows yet: draw more
    if voltage_change == 0.0:
        # The light alone has changed: more of it asks for a higher voltage.
        return -1.0 if current_change > 0.0 else 1.0 if current_change < 0.0 else 0.0
    difference = current_change / voltage_change * voltage + current
    if abs(difference) <= tolerance * current:
        return 0.0
    return -1.0 if difference > 0.0 else 1.0
