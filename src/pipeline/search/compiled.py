"""Objectives that a compiled search calls itself, with no Python in between."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numba import float64, void
from numpy.typing import NDArray

from pipeline.jit import by_address, jit

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
