"""Charge: one battery, one mode, one supply in; the trace, the enlarged windows, the summary and the energies out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, Task, simulate_many
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.digest import canonical

BATCH = 48
"""Charges that are made and written at once: one wait for the disk, and what an interruption costs."""


def supply(inputs: Inputs) -> Supply:
    """Return the power at the battery's terminals; without a supply step, a bench supply that gives any.

    Each converter has the efficiency of the power that could flow; side loads are served as far as the bus can.
    """
    if "supply" not in inputs:
        return Supply(time_s=np.zeros(1), power_w=np.full(1, np.inf))
    table = inputs.table("supply", "supply")
    boost, both = table["boost_efficiency"], table["boost_efficiency"] * table["buck_efficiency"]
    served_w = np.minimum(table["load_power_w"], table["bus_power_w"])
    return Supply(
        time_s=table["time_s"],
        power_w=table["battery_power_w"],
        drawn_per_w=np.divide(1.0, both, out=np.zeros_like(both), where=both > 0.0),
        side_w=np.divide(served_w, boost, out=np.zeros_like(boost), where=boost > 0.0),
    )


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge the battery and write what came of it."""
    run_many([(settings, inputs, output)])


def run_many(tasks: Sequence[tuple[Mapping[str, Any], Inputs, Output]]) -> None:
    """Charge for many nodes at once; what is written is bit for bit that of `run`."""
    given = {inputs.get("supply"): inputs for _, inputs, _ in tasks}
    supplies = {folder: supply(inputs) for folder, inputs in given.items()}
    known: dict[str, Any] = {}
    wanted = [_task(settings, supplies[inputs.get("supply")], known) for settings, inputs, _ in tasks]
    # A job has one core.
    for (_, _, output), charge in zip(tasks, simulate_many(wanted, threads=1), strict=True):
        output.write("trace", charge.trace)
        output.write("waveform", charge.waveform)
        output.rows("summary", charge.summary)
        output.write("phases", charge.phases)
        output.write("energy", charge.energy)


def _task(settings: Mapping[str, Any], source: Supply, known: dict[str, Any]) -> Task:
    """Return a charge; `known` keeps its records for others that have the same."""

    def record(name: str, kind: Any) -> Any:
        written = f"{name}{canonical(settings[name], ordered=True)}"
        if written not in known:
            known[written] = kind.model_validate(settings[name])
        return known[written]

    battery, mode = record("battery", Battery), record("mode", Mode)
    return Task(battery, mode, source, record("charge", ChargeSettings), record("engine", EngineSettings))
