"""A sweep's CC-CV charges on the common model, against a loop over PyBaMM's solver, which is built before; per run.

Ours is what a job of a sweep does once its kernels are loaded: all charges in one call, each artefact written to a
store and sealed. Beside it stands the computation alone.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from benchmarks import common_model
from benchmarks.peers import pybamm_thevenin
from benchmarks.protocol import Row, compared, interleaved, missing, once
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Task, simulate_many, warm_up
from pipeline.experiments.charges import charge
from pipeline.experiments.charges.tables import CHARGE
from pipeline.kernel import store
from pipeline.kernel.artefacts import Inputs, Output

PACKAGES = ("numba", "pybamm")
RUNS, INITIAL_SOC, LIMIT_V, END_A = 48, 0.3, 12.7, 0.2
RTOL = 1e-6
NAME = f"a sweep of {RUNS} CC-CV charges"
MEANS = "time at which a charge ended, the largest relative difference of both"
SETTINGS = ChargeSettings(initial_soc=INITIAL_SOC, ambient_c=25.0)


def rows() -> list[Row]:
    """Return the rows: with what a sweep writes, and without; times are those of a run of it."""
    compile_s, _ = once(warm_up)
    battery, currents_a = common_model.battery(), np.linspace(0.7, 2.1, RUNS)
    modes = [mode(float(current_a)) for current_a in currents_a]
    ours: dict[str, Callable[[], object]] = {"written": _written(battery, modes), "computed": _computed(battery, modes)}
    found = np.array(ours["computed"]())
    names = {"written": f"{NAME}, written and sealed", "computed": f"{NAME}, computed"}
    if not pybamm_thevenin.installed():
        return [missing(name, pybamm_thevenin.TITLE) for name in names.values()]
    model = common_model.model(battery)
    built_s, peer = once(lambda: pybamm_thevenin.charges(model, INITIAL_SOC, currents_a.tolist(), LIMIT_V, END_A, RTOL))
    walls = interleaved({**ours, "peer": peer}, rounds=3)
    error = float(np.max(np.abs(found / np.array(peer()) - 1.0)))
    return [
        compared(
            names[one],
            pybamm_thevenin.TITLE,
            walls[one].scaled(1.0 / RUNS),
            walls["peer"].scaled(1.0 / RUNS),
            ours_error=error,
            error_means=MEANS,
            before_s={"this project": compile_s, pybamm_thevenin.TITLE: built_s},
        )
        for one in ours
    ]


def mode(current_a: float) -> Mode:
    """Return CC-CV at a current, up to the current at which it ends."""
    return Mode.model_validate(
        {
            "title": "CC-CV",
            "max_current_a": current_a,
            "voltage_v": LIMIT_V,
            "phases": {"charge": {"constant_voltage": {}, "until": {"current_a": END_A}}},
            "stop": {"elapsed_s": 86400},
        }
    )


def _computed(battery: Battery, modes: list[Mode]) -> Callable[[], list[float]]:
    tasks = [Task(battery, one, BENCH, SETTINGS, EngineSettings()) for one in modes]

    def run() -> list[float]:
        ends = []
        for made in simulate_many(tasks, threads=1):
            ends += [one.value for one in made.summary if one.quantity == "end_time_s" and one.value is not None]
        return ends

    return run


def _written(battery: Battery, modes: list[Mode]) -> Callable[[], None]:
    """Return a job of a sweep: settings in, sealed artefacts out."""
    records = {"battery": battery, "charge": SETTINGS, "engine": EngineSettings()}
    common = {name: one.model_dump(mode="json", by_alias=True) for name, one in records.items()}
    settings = {
        f"{n:064d}": common | {"mode": one.model_dump(mode="json", by_alias=True)} for n, one in enumerate(modes)
    }

    def write(folders: Mapping[str, Path]) -> None:
        charge.run_many([(settings[key], Inputs({}, {}), Output(folder, CHARGE)) for key, folder in folders.items()])

    def run() -> None:
        folder = Path(tempfile.mkdtemp())
        try:
            store.make_many(folder, "charge", list(settings), write)
        finally:
            shutil.rmtree(folder)

    return run
