"""diffrax on the common model: Tsit5 with the edges told to it (`jump_ts`), in double precision, compiled by JAX."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable

from benchmarks.common_model import End, Model, Pulses
from benchmarks.peers.pybamm_thevenin import edges


def installed() -> bool:
    """Tell whether diffrax and JAX are there."""
    return all(importlib.util.find_spec(name) for name in ("diffrax", "jax"))


def build(m: Model, p: Pulses, rtol: float) -> Callable[[], End]:
    """Return the run."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    (_, first), (_, second), _ = p.segments
    fast, slow = m.fast, m.slow

    def slopes(time, state, args):
        phase = jnp.mod(time, p.period_s)
        pulsed = jnp.where(phase < first + second, -p.discharge_a, 0.0)
        current = jnp.where(phase < first, p.charge_a, pulsed)
        _, v1, v2, warm = state
        heat = current**2 * m.series_ohm + v1**2 / fast.resistance_ohm + v2**2 / slow.resistance_ohm
        return (
            -current / m.capacity_as,
            (current * fast.resistance_ohm - v1) / fast.time_constant_s,
            (current * slow.resistance_ohm - v2) / slow.time_constant_s,
            (heat - warm / m.thermal_k_w) / m.heat_capacity_j_k,
        )

    breaks = jnp.asarray(edges(p)[1:-1])
    control = diffrax.PIDController(rtol=rtol, atol=1e-3 * rtol)

    @jax.jit
    def solve(start, breaks):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(slopes), diffrax.Tsit5(), 0.0, p.seconds, 1e-4, start,
            stepsize_controller=diffrax.ClipStepSizeController(control, jump_ts=breaks),
            saveat=diffrax.SaveAt(t1=True), max_steps=None,
        ).ys  # fmt: skip

    def run() -> End:
        zero = jnp.asarray(0.0)
        x, fast_v, slow_v, warm = solve((jnp.asarray(1.0 - p.initial_soc), zero, zero, zero), breaks)
        return End(1.0 - float(x[0]), float(fast_v[0]), float(slow_v[0]), m.ambient_k + float(warm[0]))

    return run
