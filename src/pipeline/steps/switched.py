"""Switched: the charges' windows, battery and converters in; what the switches make of the pulses' steps out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import quantity, schemas, schemas_switched, tables
from pipeline.cell.records import Battery
from pipeline.charge import switched_columns
from pipeline.charge.switched_view import View, view
from pipeline.converter.records import SwitchedStage
from pipeline.converter.switched_quantities import of_boost


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Run the buck converter through every window of every charge, and the boost converter at maximum power."""
    battery = Battery.model_validate(settings["battery"])
    stage = SwitchedStage.model_validate(settings["switched"])
    bus_v, samples = float(settings["bus_voltage_v"]), stage.samples_per_period
    found: list[tuple[switched_columns.Place, View]] = []
    for comparison, mode in settings["charges"]:
        rows = tables.read(schemas.CHARGE_WAVEFORM, inputs[f"charge/{comparison}/{mode}"] / "waveform.parquet")
        for window in np.unique(rows["window"]).tolist():
            own = {name: column[rows["window"] == window] for name, column in rows.items()}
            made = view(battery, stage.buck, bus_v, own, samples)
            if made is not None:
                found.append((switched_columns.Place(comparison, mode, window), made))
    columns = {
        "periods": switched_columns.periods(found),
        "waveform": switched_columns.waveform(found, stage.buck.switching_period_s, samples),
        "edges": switched_columns.edges(found),
        "modes": switched_columns.modes(found, bus_v),
    }
    numbers = of_boost(
        stage.boost, bus_v, float(settings["panel_voltage_v"]), float(settings["panel_current_a"]), samples
    )
    columns["quantities"] = quantity.columns(numbers)
    for (_, name), (file, table, *_) in schemas_switched.ARTEFACTS.items():
        tables.write(table, columns[name], output / file)
