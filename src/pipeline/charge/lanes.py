"""Rows of four: the three nodes of a step and, fourth, its start, side by side so that four are one operation.

What goes into a row is computed first for all four moments: stores in between would keep the compiler from joining
them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.relaxation import PASSED
from pipeline.jit import inlined


@inlined
def put(row: NDArray[np.float64], a: float, b: float, c: float, d: float) -> None:
    """Write the values of the four moments."""
    row[0], row[1], row[2], row[3] = a, b, c, d


@inlined
def passed(of: NDArray[np.float64], j: int) -> float:
    """Return the integral of a quantity from the start to moment j, per unit of step length."""
    return float(PASSED[0, j] * of[0] + PASSED[1, j] * of[1] + PASSED[2, j] * of[2])
