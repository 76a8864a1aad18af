"""The sine of an angle in half turns, in a form of which several are computed at once."""

from __future__ import annotations

import math

import numpy as np

from pipeline.jit import inlined

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
