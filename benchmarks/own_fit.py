"""A fit of a pair and a series resistance to the pulses of a real measurement against PyBOP's: error and time.

The pulses and the rest between them at 70 and 30 % of `lfp_hppc_k2_26650`, each level by itself, one row a second,
the same open-circuit voltage and starting values for both. PyBOP needs an environment of its own, whose Python
PYBOP_PYTHON names; its time is that of the optimiser alone, imports and building left out, as ours is.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers import pybop_fit
from benchmarks.protocol import Figure, Row, missing, once, processor_time
from pipeline.cell.records import Battery, Pair, Polynomial, Thermal
from pipeline.experiments.own_battery.fitting import Part, Problem, Spread, solve
from pipeline.experiments.own_battery.reading import Series, measured_series
from pipeline.experiments.own_battery.records import Measured
from pipeline.experiments.own_battery.segments import PULSE, charge_ah, segments, whole
from pipeline.experiments.own_battery.unknowns import Model, unknowns_of

PACKAGES = ("numba", "scipy")
FILE = Path(__file__).resolve().parents[2] / "shared" / "data" / "lfp_hppc_k2_26650" / "HPPC_20C.csv"
CAPACITY_AH, LEVELS, BEFORE_S = 2.19, (0.7, 0.3), 30
START = {"r0": 0.02, "r1": 0.02, "tau_s": 15.0}
PATHS = {"r0": "series_resistance_ohm", "r1": "pairs.slow.resistance_ohm", "tau_s": "pairs.slow.time_constant_s"}
ROUNDS = 7
FASTER = Figure(20.0)


def rows() -> list[Row]:
    """Return a row for each level and method of PyBOP."""
    names = [f"fit of the pulses at {100 * level:.0f} %" for level in LEVELS]
    python = pybop_fit.find()
    if python is None or not FILE.is_file():
        return [missing(name, pybop_fit.TITLE, FASTER) for name in names]
    series = measured_series(Measured(file=str(FILE), sample_interval_s=1.0))[0]
    made = []
    for name, level in zip(names, LEVELS, strict=True):
        stretch, soc = _stretch(series, level)
        ours = _ours(stretch, soc)
        for method, peer in _peer(python, stretch, soc).items():
            made.append(_row(name, method, ours, peer))
    return made


def _stretch(series: Series, level: float) -> tuple[Series, float]:
    """Return the pulses at a level with the rest between them, and the SOC where they begin."""
    found = segments(series, 1.0, CAPACITY_AH)
    pulses = [one for one in found if one.kind == PULSE and abs(one.soc - level) < 0.04]
    first, last = pulses[0].first - BEFORE_S, pulses[-1].last
    fields = {
        name: getattr(series, name)[first : last + 1]
        for name in ("row", "time_s", "voltage_v", "current_a", "temperature_c", "ambient_c", "step")
    }
    fields["time_s"] = fields["time_s"] - fields["time_s"][0]
    return series._replace(**fields), 1.0 + float(charge_ah(series)[first]) / CAPACITY_AH


def _battery(open_v: float) -> Battery:
    return Battery(
        name="fit",
        title="What is fitted",
        cells_in_series=1,
        capacity_ah=CAPACITY_AH,
        open_circuit_voltage_v=Polynomial(polynomial=[open_v, 0.0]),
        series_resistance_ohm=START["r0"],
        pairs={"slow": Pair(resistance_ohm=START["r1"], time_constant_s=START["tau_s"])},
        thermal=Thermal(heat_capacity_j_k=100.0, resistance_k_w=5.0),
    )


def _ours(stretch: Series, soc: float) -> dict[str, Any]:
    """Return our numbers, error [V], and median seconds of a fit from the start, of the clock and of the processor."""
    rest_v = float(np.mean(stretch.voltage_v[:BEFORE_S]))
    every = whole(stretch, float(stretch.ambient_c[0]))
    part = Part(every, np.ones(len(every.kept), dtype=bool), np.full(len(every.kept), -1))
    model: Model = unknowns_of(_battery(rest_v), [soc], (1.0, 200.0), False, {}, [True])
    model = model.without([path for path in model.paths if path not in PATHS.values()])
    problem = Problem(model, [part], Spread(1e-3, 1.0))
    solve(problem)
    times = []
    for _ in range(ROUNDS):
        spent = processor_time()
        wall, found = once(lambda: solve(problem, robust=1e6))
        times.append((wall, processor_time() - spent))
    wall, processor = np.median(np.array(times), axis=0).tolist()
    missed = problem.replayed(found.vector[None])[0].voltage_v[0] - stretch.voltage_v
    values = dict(zip(model.paths, model.values(found.vector[None])[0].tolist(), strict=True))
    return {
        "values": {name: values[path] for name, path in PATHS.items()}, "rmse_v": float(np.sqrt(np.mean(missed**2))),
        "wall_s": wall, "processor_s": processor,
    }  # fmt: skip


def _peer(python: str, stretch: Series, soc: float) -> dict[str, Any]:
    rest_v = float(np.mean(stretch.voltage_v[:BEFORE_S]))
    task = {
        "time_s": stretch.time_s.tolist(), "discharge_a": (-stretch.current_a).tolist(),
        "voltage_v": stretch.voltage_v.tolist(), "soc": [0.0, 0.5, 1.0], "open_v": [rest_v] * 3,
        "capacity_ah": CAPACITY_AH, "start_soc": soc, "start": START, "factor": 30.0, "methods": pybop_fit.METHODS,
    }  # fmt: skip
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(task, file)
        file.flush()
        made = subprocess.run(
            [python, pybop_fit.__file__, file.name], capture_output=True, text=True, check=True, timeout=1800
        )
    found: dict[str, Any] = json.loads(made.stdout)
    return found


def _row(name: str, method: str, ours: dict[str, Any], peer: dict[str, Any]) -> Row:
    ratio = peer["wall_s"] / ours["wall_s"]
    numbers = f"{peer['version']}; {peer['evaluations']} evaluations; " + "; ".join(
        f"{who}: R0 {1e3 * one['r0']:.2f} mOhm, R1 {1e3 * one['r1']:.2f} mOhm, {one['tau_s']:.1f} s"
        for who, one in (("ours", ours["values"]), ("PyBOP", peer["values"]))
    )
    return Row(
        name, f"{pybop_fit.TITLE}, {method}", ours["wall_s"], peer["wall_s"], ratio, ratio, ratio,
        peer["processor_s"] / ours["processor_s"], ours["rmse_v"], peer["rmse_v"], "rmse of the voltage [V]",
        # No larger error, but for what the two end their searches with.
        1.001 * peer["rmse_v"], FASTER, rounds=1, note=numbers,
    )  # fmt: skip
