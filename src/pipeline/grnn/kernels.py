"""Radial basis functions of the network: how much a centre counts at a distance from it."""

from __future__ import annotations

import math

from pipeline.grnn.records import Kernel
from pipeline.jit import inlined

KERNELS: tuple[Kernel, ...] = ("gaussian", "wendland", "extendable")
GAUSSIAN, WENDLAND, EXTENDABLE = range(3)
"""Codes of the kernels: their places in `KERNELS`."""
EDGE = 1.0 - 1e-9
"""Where a support ends; on a grid centres lie at its edge, where rounding must not decide which of them counts."""


@inlined
def weight(kernel: int, squared: float, nearest: float, extension: float) -> float:
    """Return the weight of a centre at a query.

    Gaussian: exp(-d^2/2), with the nearest centre's d^2 taken off, which cancels in the network's ratio and keeps one
    weight at 1 however far the query is. Wendland: (1 - d)^4 (4 d + 1) for d < 1, else 0 (Adv. Comput. Math. 4 (1995)
    389, DOI 10.1007/BF02123482). Extendable: Wendland's function on a support of radius max(1, extension x distance of
    the nearest centre), so that every query lies in one; the paper names such a function and gives no formula, so this
    one is ours.

    Arguments
    ---------
    kernel : its code.
    squared : squared distance from the centre, in widths [1].
    nearest : that of the nearest centre.
    extension : support's radius over the nearest centre's distance, above 1; counts for the extendable kernel alone.
    """
    if kernel == GAUSSIAN:
        return math.exp(-0.5 * (squared - nearest))
    radius = 1.0
    if kernel == EXTENDABLE:
        radius = max(1.0, extension * math.sqrt(nearest))
    distance = math.sqrt(squared) / radius
    if distance >= EDGE:
        return 0.0
    rest = (1.0 - distance) * (1.0 - distance)
    return rest * rest * (4.0 * distance + 1.0)
