"""The kernels behind `maximum_power`: a straight line of arithmetic over conditions, and loops for what it leaves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined, kernel

Array = NDArray[np.float64]

STRAIGHT_STEPS = 3
SETTLED = 1e-5
"""Last step of third order, relative to the ideality, after which no more than rounding is left."""
NEAR = 0.5
"""Steps, relative to the ideality, that the short exponential takes."""
_MOST_STEPS = 100
_QUADRATIC = 1e-8
_TERMS = 12
_INVERSE = (0.0, *(1.0 / order for order in range(1, _TERMS + 1)))


@inlined
def _near_exponential(x: float) -> float:
    """Return exp(x) for |x| below a half or so, to rounding: without a branch or a call, so that it vectorises."""
    total = 1.0
    for order in range(_TERMS, 0, -1):
        total = 1.0 + x * _INVERSE[order] * total
    return total


@inlined
def _step(
    total: float, grown: float, voltage: float, series: float, conductance: float, per_v: float
) -> tuple[float, float]:
    """Return Halley's step in the diode voltage towards dP/dV_d = 0, and that slope.

    Arguments
    ---------
    total : photocurrent and saturation current [A]; grown : saturation current times exp(V_d / a) [A].
    per_v : 1 / a [1/V].
    """
    bend = grown * per_v
    slope = bend + conductance
    current = total - grown - voltage * conductance
    outside = voltage - 2.0 * current * series
    rise = current - slope * outside
    widens = 1.0 + 2.0 * series * slope
    first = -slope - bend * per_v * outside - slope * widens
    second = -bend * per_v * (1.0 + 2.0 * widens + 2.0 * series * slope + per_v * outside)
    return -rise * first / (first * first - 0.5 * rise * second), rise


@kernel
def fill_maximum(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    start: Array,
    grown: Array,
    series: float,
    current: Array,
    voltage: Array,
    last: Array,
) -> None:
    """Fill in the maximum power after three steps; vectorised, since nothing in it depends on a comparison.

    Arguments
    ---------
    photo, saturation, conductance, ideality : parameters of each condition [A], [A], [S], [V], shape (n,).
    start : diode voltage to begin with over the ideality; grown : saturation current times its exponential [A].
    series : series resistance [ohm].
    current, voltage : terminal current and voltage at maximum power, filled in.
    last : last step over the ideality, filled in; 1 where a step was too long for its exponential.
    """
    for here in range(photo.shape[0]):
        per_v = 1.0 / ideality[here]
        total, shunt = photo[here] + saturation[here], conductance[here]
        inside, diode_current = start[here] * ideality[here], grown[here]
        moved, farthest = 0.0, 0.0
        for _ in range(STRAIGHT_STEPS):
            step, _rise = _step(total, diode_current, inside, series, shunt, per_v)
            moved = abs(step * per_v)
            farthest = max(farthest, moved)
            inside += step
            diode_current *= _near_exponential(step * per_v)
        found = total - diode_current - inside * shunt
        current[here] = found
        voltage[here] = inside - found * series
        last[here] = moved if farthest <= NEAR else 1.0


@kernel
def refill_maximum(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    series: float,
    current: Array,
    voltage: Array,
    last: Array,
) -> None:
    """Find those again that three steps did not settle, between short and open circuit; arguments as above."""
    for here in range(photo.shape[0]):
        if abs(last[here]) <= SETTLED:
            continue
        per_v, total = 1.0 / ideality[here], photo[here] + saturation[here]
        low, high = 0.0, ideality[here] * math.log1p(photo[here] / saturation[here])
        inside = 0.5 * high
        for _ in range(_MOST_STEPS):
            grown = saturation[here] * math.exp(inside * per_v)
            step, rise = _step(total, grown, inside, series, conductance[here], per_v)
            if rise > 0.0:
                low = inside
            else:
                high = inside
            following = inside + step
            if not low <= following <= high:
                following = 0.5 * (low + high)
            step, inside = following - inside, following
            if abs(step) * per_v <= SETTLED**2:
                break
        found = total - saturation[here] * math.exp(inside * per_v) - inside * conductance[here]
        current[here] = found
        voltage[here] = inside - found * series
        last[here] = 0.0


@kernel
def fill_ends(
    photo: Array,
    saturation: Array,
    conductance: Array,
    ideality: Array,
    series: float,
    short_a: Array,
    open_v: Array,
) -> None:
    """Fill in short-circuit current and open-circuit voltage by Newton's method; arguments as above.

    The current is concave in the diode voltage and falls: from above, every step to open circuit stays above.
    """
    for here in range(photo.shape[0]):
        short_a[here], open_v[here] = 0.0, 0.0
        if photo[here] <= 0.0:
            continue
        total, per_v = photo[here] + saturation[here], 1.0 / ideality[here]
        voltage = ideality[here] * math.log(total / saturation[here])
        for _ in range(_MOST_STEPS):
            grown = saturation[here] * math.exp(voltage * per_v)
            step = (total - grown - voltage * conductance[here]) / (grown * per_v + conductance[here])
            voltage += step
            if abs(step) * per_v <= _QUADRATIC:
                break
        open_v[here] = voltage
        short_a[here] = total - saturation[here]
        if series > 0.0:
            voltage = min(total * series / (1.0 + series * conductance[here]), voltage)
            for _ in range(_MOST_STEPS):
                grown = saturation[here] * math.exp(voltage * per_v)
                off = (total - grown - voltage * conductance[here]) * series - voltage
                step = off / (1.0 + series * (grown * per_v + conductance[here]))
                voltage += step
                if abs(step) <= _QUADRATIC * voltage:
                    break
            short_a[here] = voltage / series
