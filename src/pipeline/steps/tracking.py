"""Tracking: panel, boost converter and trackers in; what each captures of ramps, days and shadows out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from pipeline import quantity, schemas, schemas_supply, tables
from pipeline.converter.records import SwitchedBoost
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker import ramps, shading, skies
from pipeline.tracker.capture import Source
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.summary import summary
from pipeline.tracker.tracking_records import Tracking

_TRACKERS: TypeAdapter[dict[str, AnyTracker]] = TypeAdapter(dict[str, AnyTracker])


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Try every tracker on everything that is configured."""
    fitted = tables.read(schemas.PANEL_PARAMETERS, inputs["panel"] / "parameters.parquet")
    source = Source(
        Panel.model_validate(settings["panel"]),
        SingleDiode(**{name: float(fitted[name][0]) for name in SingleDiode._fields}),
        SwitchedBoost.model_validate(settings["boost"]),
        float(settings["bus_voltage_v"]),
    )
    trackers = _TRACKERS.validate_python(settings["trackers"])
    tracking = Tracking.model_validate(settings["tracking"])
    found: dict[str, Any] = {
        "ramps": ramps.efficiencies(source, trackers, tracking),
        "course": ramps.shown_course(source, trackers, tracking),
        "day": skies.captured(source, trackers, tracking.skies),
    }
    curves, ends = shading.ends(source, trackers, tracking.shading, tracking.cell_temperature_c)
    found |= {"shading_curves": curves, "shading_ends": ends}
    found["quantities"] = quantity.columns(summary(source, trackers, tracking, found["ramps"]))
    for name, columns in found.items():
        file, table = schemas_supply.ARTEFACTS["tracking", name]
        tables.write(table, columns, output / file)
