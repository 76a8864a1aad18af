"""Switched: the charges' windows, battery and converters in; what the switches make of the pulses' steps out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.converter.records import SwitchedStage
from pipeline.converter.switched import of_boost
from pipeline.experiments.switched import columns
from pipeline.experiments.switched.view import View, view
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Run the buck converter through every window of every charge, and the boost converter at maximum power."""
    battery = Battery.model_validate(settings["battery"])
    stage = SwitchedStage.model_validate(settings["switched"])
    bus_v, samples = float(settings["bus_voltage_v"]), stage.samples_per_period
    found: list[tuple[columns.Place, View]] = []
    for comparison, mode in settings["charges"]:
        rows = inputs.table(f"charge/{comparison}/{mode}", "waveform")
        for window in np.unique(rows["window"]).tolist():
            own = {name: column[rows["window"] == window] for name, column in rows.items()}
            made = view(battery, stage.buck, bus_v, own, samples)
            if made is not None:
                found.append((columns.Place(comparison, mode, window), made))
    output.write("periods", columns.periods(found))
    output.write("waveform", columns.waveform(found, stage.buck.switching_period_s, samples))
    output.write("edges", columns.edges(found))
    output.write("modes", columns.modes(found, bus_v))
    panel_v, panel_a = float(settings["panel_voltage_v"]), float(settings["panel_current_a"])
    output.numbers(of_boost(stage.boost, bus_v, panel_v, panel_a, samples))
