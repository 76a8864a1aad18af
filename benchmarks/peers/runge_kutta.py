"""A plain loop of Runge and Kutta's fourth order, compiled by numba: what a good user writes in an hour.

Divisions are taken out of the loop; each part of a period gets steps of about the same length.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numba

from benchmarks.common_model import End, Model, Pulses

TITLE = "Runge-Kutta, numba"
LADDER = (2, 4, 8, 12, 16, 32, 64, 128, 256)
"""Steps of the longest part of a period."""


@numba.njit(error_model="numpy")
def _slopes(current, v1, v2, warm, x, r0, r1, r2, rate1, rate2, g1, g2, full, slope, per_heat, cooling):
    heat = current * current * r0 + v1 * v1 * g1 + v2 * v2 * g2
    power = current * (full + slope * x + v1 + v2 + current * r0)
    return (current * r1 - v1) * rate1, (current * r2 - v2) * rate2, heat * per_heat - warm * cooling, power


@numba.njit(error_model="numpy")
def _run(currents, lengths, steps, periods, x, per_charge, r0, r1, r2, tau1, tau2, full, slope, capacity, thermal):
    v1 = v2 = warm = energy = 0.0
    rate1, rate2, g1, g2 = 1.0 / tau1, 1.0 / tau2, 1.0 / r1, 1.0 / r2
    per_heat, cooling = 1.0 / capacity, 1.0 / (capacity * thermal)
    for _ in range(periods):
        for part in range(len(currents)):
            i, h = currents[part], lengths[part] / steps[part]
            dx = -i * per_charge
            for _ in range(steps[part]):
                c = (r0, r1, r2, rate1, rate2, g1, g2, full, slope, per_heat, cooling)
                half, middle = 0.5 * h, x + 0.5 * h * dx
                a1, a2, aw, ae = _slopes(i, v1, v2, warm, x, *c)
                b1, b2, bw, be = _slopes(i, v1 + half * a1, v2 + half * a2, warm + half * aw, middle, *c)
                c1, c2, cw, ce = _slopes(i, v1 + half * b1, v2 + half * b2, warm + half * bw, middle, *c)
                x += h * dx
                d1, d2, dw, de = _slopes(i, v1 + h * c1, v2 + h * c2, warm + h * cw, x, *c)
                sixth = h / 6.0
                v1 += sixth * (a1 + 2.0 * (b1 + c1) + d1)
                v2 += sixth * (a2 + 2.0 * (b2 + c2) + d2)
                warm += sixth * (aw + 2.0 * (bw + cw) + dw)
                energy += sixth * (ae + 2.0 * (be + ce) + de)
    return x, v1, v2, warm, energy


def build(m: Model, p: Pulses, steps: int) -> Callable[[], End]:
    """Return the loop with so many steps in the longest part of a period, and as fine ones in the others."""
    currents, lengths = zip(*p.segments, strict=True)
    counts = tuple(math.ceil(steps * length / max(lengths) - 1e-9) for length in lengths)

    def run() -> End:
        x, fast, slow, warm, energy = _run(
            currents, lengths, counts, p.periods, 1.0 - p.initial_soc, 1.0 / m.capacity_as, m.series_ohm,
            m.fast.resistance_ohm, m.slow.resistance_ohm, m.fast.time_constant_s, m.slow.time_constant_s, m.full_v,
            m.slope_v, m.heat_capacity_j_k, m.thermal_k_w,
        )  # fmt: skip
        return End(1.0 - x, fast, slow, m.ambient_k + warm, energy)

    return run
