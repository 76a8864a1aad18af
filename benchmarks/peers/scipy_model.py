"""scipy's `solve_ivp` on the common model in its best form: started anew at every edge, right-hand side compiled."""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.common_model import End, Model, Pulses


@numba.njit(error_model="numpy")
def _slopes(_, state, current, constants):
    per_charge, r0, r1, r2, rate1, rate2, g1, g2, per_heat, cooling, full, slope = constants
    x, v1, v2, warm, _ = state
    heat = current * current * r0 + v1 * v1 * g1 + v2 * v2 * g2
    out = np.empty(5)
    out[0] = -current * per_charge
    out[1], out[2] = (current * r1 - v1) * rate1, (current * r2 - v2) * rate2
    out[3] = heat * per_heat - warm * cooling
    out[4] = current * (full + slope * x + v1 + v2 + current * r0)
    return out


def build(m: Model, p: Pulses, method: str, rtol: float) -> Callable[[], End]:
    """Return the run; absolute tolerances are a thousandth of rtol of what each state comes to."""
    fast, slow = m.fast, m.slow
    constants = (
        1.0 / m.capacity_as, m.series_ohm, fast.resistance_ohm, slow.resistance_ohm, 1.0 / fast.time_constant_s,
        1.0 / slow.time_constant_s, 1.0 / fast.resistance_ohm, 1.0 / slow.resistance_ohm, 1.0 / m.heat_capacity_j_k,
        1.0 / (m.heat_capacity_j_k * m.thermal_k_w), m.full_v, m.slope_v,
    )  # fmt: skip
    atol = rtol * np.array([1e-3, 1e-3, 1e-3, 1e-4, 1.0])

    def run() -> End:
        state = np.array([1.0 - p.initial_soc, 0.0, 0.0, 0.0, 0.0])
        for _ in range(p.periods):
            for current, length in p.segments:
                state = solve_ivp(
                    _slopes, (0.0, length), state, method=method, rtol=rtol, atol=atol, args=(current, constants)
                ).y[:, -1]
        return End(1.0 - state[0], state[1], state[2], m.ambient_k + state[3], state[4])

    return run
