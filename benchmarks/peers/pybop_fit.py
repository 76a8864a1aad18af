"""PyBOP's fit of a Thevenin model to a stretch of a measurement, run by a Python of its own: it pins another numpy.

    PYTHON_WITH_PYBOP benchmarks/peers/pybop_fit.py TASK.json

The task holds time [s], current positive when discharging [A], voltage [V], an open-circuit voltage by SOC, capacity,
SOC at the start, and where R0, R1 and the time constant start; what comes of it is printed as JSON. `find` returns that
Python: the one that PYBOP_PYTHON names.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from pathlib import Path
from typing import Any

TITLE = "PyBOP, Thevenin, one pair"
METHODS = ("scipy", "cmaes")


def find() -> str | None:
    """Return the Python that has PyBOP; none where PYBOP_PYTHON names none."""
    return shutil.which(os.environ.get("PYBOP_PYTHON", "")) if os.environ.get("PYBOP_PYTHON") else None


def fit(task: dict[str, Any], method: str) -> dict[str, Any]:
    """Fit; return the numbers, the error of the voltage [V], the evaluations, the seconds by clock and processor."""
    import numpy as np
    import pybamm
    import pybop

    grid, volts = np.array(task["soc"]), np.array(task["open_v"])

    def open_circuit(soc: Any) -> Any:
        return pybamm.Interpolant(grid, volts, soc, "open circuit")

    model = pybamm.equivalent_circuit.Thevenin(options={"number of rc elements": 1})
    values = model.default_parameter_values
    values.update(
        {
            "Initial SoC": task["start_soc"],
            "Cell capacity [A.h]": task["capacity_ah"],
            "Nominal cell capacity [A.h]": task["capacity_ah"],
            "Open-circuit voltage [V]": open_circuit,
            "Upper voltage cut-off [V]": 5.0,
            "Lower voltage cut-off [V]": 0.5,
            "Element-1 initial overpotential [V]": 0.0,
            "Entropic change [V/K]": 0.0,
        }
    )
    r0, r1, tau = (task["start"][name] for name in ("r0", "r1", "tau_s"))
    wide = task["factor"]

    def unknown(value: float) -> Any:
        return pybop.Parameter(
            bounds=[value / wide, value * wide], initial_value=value, transformation=pybop.LogTransformation()
        )

    values.update({"R0 [Ohm]": unknown(r0), "R1 [Ohm]": unknown(r1), "C1 [F]": unknown(tau / r1)})
    data = pybop.Dataset(
        {
            "Time [s]": np.array(task["time_s"]),
            "Current [A]": np.array(task["discharge_a"]),
            "Voltage [V]": np.array(task["voltage_v"]),
        }
    )
    # With steps of its own choice the solver passes over pulses that come after a rest, and fits 21 mV instead of 7.
    solver = pybamm.IDAKLUSolver(rtol=1e-6, atol=1e-6, options={"dt_max": 1.0})
    simulator = pybop.pybamm.Simulator(model, parameter_values=values, protocol=data, solver=solver)
    problem = pybop.Problem(simulator, pybop.SumSquaredError(data, target=["Voltage [V]"]))
    if method == "scipy":
        optimiser = pybop.SciPyMinimize(problem, pybop.SciPyMinimizeOptions(method="Nelder-Mead", maxiter=400))
    else:
        optimiser = pybop.CMAES(problem, pybop.PintsOptions(max_iterations=100))
    begun, spent = time.perf_counter(), time.process_time()
    result = optimiser.run()
    begun, spent = time.perf_counter() - begun, time.process_time() - spent
    found = np.asarray(result.x, dtype=float)
    solution = simulator.solve(dict(zip(problem.parameters.names, found.tolist(), strict=True)))
    missed = np.asarray(solution["Voltage [V]"].data) - np.array(task["voltage_v"])
    return {
        "values": {"r0": found[0], "r1": found[1], "tau_s": found[1] * found[2]},
        "rmse_v": float(np.sqrt(np.mean(missed**2))), "evaluations": int(result.n_evaluations),
        "wall_s": begun, "processor_s": spent, "version": f"PyBOP {pybop.__version__}, numpy {np.__version__}",
    }  # fmt: skip


if __name__ == "__main__":
    os.environ.setdefault("PYBAMM_DISABLE_TELEMETRY", "true")
    given = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    json.dump({method: fit(given, method) for method in given["methods"]}, sys.stdout)
