"""Switched ensemble: the steps of the pulses over points of the estimated parameters; what statements read out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.charge.comparison import compared, level_of
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, Task, simulate_many
from pipeline.converter.records import SwitchedStage
from pipeline.experiments.switched import columns
from pipeline.experiments.switched.view import View, view
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published import ensemble
from pipeline.published.artefacts import Lookup


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge up to the first window in every point, and run the buck converter through it."""
    table = inputs.table("supply", "supply")
    supply = Supply(time_s=table["time_s"], power_w=table["battery_power_w"])
    rows: list[ensemble.Row] = []
    points = ensemble.draw(settings["estimated"], settings["points"], settings["seed"])
    for number, values in enumerate(points):
        try:
            reader: Lookup | None = _reader(settings, values, supply)
        except ensemble.IMPOSSIBLE:
            reader = None
        rows += ensemble.answers(number, settings["asked"], reader)
        print(f"{number + 1} of {len(points)} points", flush=True)
    output.rows("ensemble", rows)


def _reader(settings: Mapping[str, Any], values: Mapping[str, float], supply: Supply) -> Lookup:
    parts = {name: settings[name] for name in ("battery", "modes", "charge")}
    tree = ensemble.with_values({**parts, "converter": {"switched": settings["switched"]}}, values)
    battery = Battery.model_validate(tree["battery"])
    stage = SwitchedStage.model_validate(tree["converter"]["switched"])
    modes = {name: Mode.model_validate(mode) for name, mode in tree["modes"].items()}
    engine = EngineSettings.model_validate(settings["engine"])
    window = settings["charge"]["windows"][0]
    charge = ChargeSettings.model_validate({**tree["charge"], "windows": [window], "soc_marks": []})
    end_s = window["start_s"] + 2.0 * window["length_s"]
    tasks: dict[tuple[str, str], Task] = {}
    for comparison, mode in settings["charges"]:
        sheet = compared(modes[mode], level_of(settings["comparisons"][comparison], modes), battery, None)
        # What comes after the window is of no interest.
        sheet = sheet.model_copy(update={"stop": sheet.stop.model_copy(update={"elapsed_s": end_s})})
        tasks[comparison, mode] = Task(battery, sheet, supply, charge, engine)
    bus_v, samples = float(settings["bus_voltage_v"]), stage.samples_per_period
    found: list[tuple[columns.Place, View]] = []
    for (comparison, mode), done in zip(tasks, simulate_many(tasks.values()), strict=True):
        own = {name: np.asarray(column) for name, column in done.waveform.items()}
        made = view(battery, stage.buck, bus_v, own, samples) if len(own["time_s"]) > 1 else None
        if made is not None:
            found.append((columns.Place(comparison, mode, 0), made))
    return ensemble.reader({"switched": {"modes": columns.modes(found, bus_v)}})
