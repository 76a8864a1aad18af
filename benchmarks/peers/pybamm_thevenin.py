"""PyBaMM's Thevenin model, solved by IDAKLU, in the form that is fastest for pulses.

The current is a function of time by `Modulo`, every edge is a breakpoint in `t_eval`, and only the end is kept
(`t_interp`): an `Experiment` of steps or a tabulated current takes many times as long. Its current is positive when
discharging, and what it calls heat of a pair is i v, the energy that the capacitor stores included.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.common_model import KELVIN, End, Model, Pulses

TITLE = "PyBaMM, Thevenin, IDAKLU"
# The jig around the cell stays at the ambient's temperature.
_HUGE = 1e12
_LONGEST_S = 1e5


def installed() -> bool:
    """Tell whether PyBaMM is there; it must not report to anyone from a benchmark."""
    os.environ.setdefault("PYBAMM_DISABLE_TELEMETRY", "true")
    return importlib.util.find_spec("pybamm") is not None


def edges(p: Pulses) -> np.ndarray:
    """Return the time of every edge, from 0 to the end [s]."""
    lengths = [length for _, length in p.segments]
    ends = np.cumsum(lengths)[:-1]
    starts = p.period_s * np.arange(p.periods)
    return np.append(np.sort(np.concatenate([starts, *(starts + end for end in ends)])), p.periods * p.period_s)


def build(m: Model, p: Pulses, rtol: float) -> Callable[[], End]:
    """Return the run: one `solve` of a simulation that is built and compiled before."""
    import pybamm

    pybamm.set_logging_level("ERROR")
    first, second = np.cumsum([length for _, length in p.segments])[:2]

    def current(time):
        phase = pybamm.Modulo(time, p.period_s)
        return -p.charge_a * (phase < first) + p.discharge_a * (phase >= first) * (phase < second)

    model, values = _thevenin(m, p.initial_soc)
    values.update({"Current function [A]": current})
    solver = pybamm.IDAKLUSolver(rtol=rtol, atol=1e-3 * rtol)
    simulation = pybamm.Simulation(model, parameter_values=values, solver=solver)
    simulation.build()
    breaks, ends = edges(p), np.array([0.0, p.periods * p.period_s])

    def run() -> End:
        solution = simulation.solve(t_eval=breaks, t_interp=ends)
        last = [
            float(solution[name].entries[-1])
            for name in (
                "SoC", "Element-1 overpotential [V]", "Element-2 overpotential [V]", "Cell temperature [degC]",
            )
        ]  # fmt: skip
        return End(last[0], last[1], last[2], last[3] + KELVIN)

    return run


def charges(
    m: Model, initial_soc: float, currents_a: Sequence[float], limit_v: float, end_a: float, rtol: float
) -> Callable[[], list[float]]:
    """Return the run of a sweep: CC-CV at each current, one solve after the other, each built and compiled before.

    Returns
    -------
    A run that returns the time at which each charge ended [s].
    """
    import pybamm

    pybamm.set_logging_level("ERROR")
    solver = pybamm.IDAKLUSolver(rtol=rtol, atol=1e-3 * rtol)
    simulations = []
    for current_a in currents_a:
        model, values = _thevenin(m, initial_soc)
        steps = (
            pybamm.step.current(-current_a, duration=_LONGEST_S, termination=f"{limit_v!r} V"),
            pybamm.step.voltage(limit_v, duration=_LONGEST_S, termination=f"{end_a!r} A"),
        )
        experiment = pybamm.Experiment([steps], period=None)
        simulation = pybamm.Simulation(model, experiment=experiment, parameter_values=values, solver=solver)
        simulation.solve()
        simulations.append(simulation)
    return lambda: [float(simulation.solve().t[-1]) for simulation in simulations]


def _thevenin(m: Model, initial_soc: float) -> tuple[Any, Any]:
    """Return PyBaMM's model with two pairs, and its parameter values for the common model."""
    import pybamm

    model = pybamm.equivalent_circuit.Thevenin(options={"number of rc elements": 2})
    values = model.default_parameter_values
    values.update(
        {
            "Cell capacity [A.h]": m.capacity_as / 3600.0,
            "Nominal cell capacity [A.h]": m.capacity_as / 3600.0,
            "Initial SoC": initial_soc,
            "Open-circuit voltage [V]": lambda soc: m.full_v + m.slope_v * (1.0 - soc),
            "Entropic change [V/K]": lambda ocv, temperature: pybamm.Scalar(0.0),
            "R0 [Ohm]": m.series_ohm,
            "R1 [Ohm]": m.fast.resistance_ohm,
            "C1 [F]": m.fast.time_constant_s / m.fast.resistance_ohm,
            "R2 [Ohm]": m.slow.resistance_ohm,
            "C2 [F]": m.slow.time_constant_s / m.slow.resistance_ohm,
            "Element-1 initial overpotential [V]": 0.0,
            "Element-2 initial overpotential [V]": 0.0,
            "Cell thermal mass [J/K]": m.heat_capacity_j_k,
            "Cell-jig heat transfer coefficient [W/K]": 1.0 / m.thermal_k_w,
            "Jig thermal mass [J/K]": _HUGE,
            "Ambient temperature [K]": m.ambient_k,
            "Initial temperature [K]": m.ambient_k,
            "Lower voltage cut-off [V]": 0.0,
            "Upper voltage cut-off [V]": 100.0,
        },
        check_already_exists=False,
    )
    return model, values
