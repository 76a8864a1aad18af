"""Objectives that a compiled search calls itself, with no Python in between."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numba import float64, void
from numpy.typing import NDArray

from pipeline.jit import by_address, inlined, jit

Array = NDArray[np.float64]
Kernel = Callable[[Array, Array, Array], None]
"""Numbers that say which problem it is (m,), positions (n, d), and the values (n,) that it writes."""

_SIGNATURE = void(float64[::1], float64[:, ::1], float64[::1])


class Compiled:
    """An objective as any other: positions (n, d) to values (n,); and its kernel for those who can call it."""

    def __init__(self, kernel: Kernel, numbers: Array) -> None:
        self._kernel = kernel
        self.jitted = jit(kernel)
        self.numbers = np.ascontiguousarray(numbers, dtype=np.float64)

    def __call__(self, positions: Array) -> Array:
        """Return the values (n,) of positions (n, d)."""
        values = np.empty(len(positions))
        self.jitted(self.numbers, np.ascontiguousarray(positions, dtype=np.float64), values)
        return values

    @cached_property
    def address(self) -> Any:
        """Return the kernel in the one type that all kernels share, so that a search is compiled once for all."""
        return by_address(_SIGNATURE, self._kernel)


_TERMS = 12
# Taylor's series of sin(pi x); at x = 1/2 the first term left out is below 1e-19.
_SERIES = tuple((-1.0) ** k * math.pi ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(_TERMS))


@inlined
def sine(half_turns: float) -> float:
    """Return sin(pi x) of -1/2 <= x <= 1/2, to the last digit but one."""
    square = half_turns * half_turns
    total = _SERIES[_TERMS - 1]
    for k in range(_TERMS - 2, -1, -1):
        total = total * square + _SERIES[k]
    return half_turns * total


@inlined
def sine_squared(half_turns: float) -> float:
    """Return sin(pi x)^2 of any x; 2 sin(pi x)^2 is 1 - cos(2 pi x) without its cancellation near whole numbers."""
    # numpy's floor stays a float: several are rounded at once.
    found = sine(half_turns - np.floor(half_turns + 0.5))
    return found * found
