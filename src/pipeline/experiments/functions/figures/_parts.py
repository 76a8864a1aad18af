"""What the figures of the test functions share: their names, and an axis of values that may be exactly 0."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axis import Axis

    from pipeline.report.tables import Columns


FLOOR = 1e-20
"""Everything below is drawn here; in double precision such a value and 0 are the same finding."""

NAMES = {
    "sphere": "Sphere",
    "schwefel_222": "Schwefel 2.22",
    "schwefel_12": "Schwefel 1.2",
    "rosenbrock": "Rosenbrock",
    "rastrigin": "Rastrigin",
    "griewank": "Griewank",
    "ackley": "Ackley",
}
PLACES = {
    "centred": "minimum at the origin",
    "shifted": "minimum elsewhere",
    "rotated": "elsewhere, and turned",
}


def rows_of(table: Columns, function: str, placement: str, search: str) -> NDArray[np.bool_]:
    """Return the rows of one search on one function in one placement."""
    rows: NDArray[np.bool_] = (
        (table["function"] == function) & (table["placement"] == placement) & (table["search"] == search)
    )
    return rows


def floored(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values as they are drawn on a logarithmic axis that ends at the floor."""
    return np.maximum(values, FLOOR)


def value_ticks(axis: Axis, low: float = FLOOR, high: float = 1.0) -> None:
    """Label a logarithmic axis between two values, at most four powers of ten; at the floor stands 0."""
    first = int(np.ceil(np.log10(low))) if low > FLOOR else -12
    last = int(np.floor(np.log10(high)))
    step = next((step for step in (1, 2, 3, 6, 12, 24, 48) if (last - first) // step <= 3), 96)
    exponents = [number for number in range(first, last + 1) if number % step == 0]
    floor = [FLOOR] if low <= FLOOR else []
    axis.set_ticks([*floor, *(10.0**exponent for exponent in exponents)])
    axis.set_ticklabels([*("0" for _ in floor), *(f"$10^{{{exponent}}}$" for exponent in exponents)])
    axis.set_ticks([], minor=True)
