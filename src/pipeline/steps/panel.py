"""Panel: the data sheet in; single-diode parameters, curves and their characteristic points out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, schemas_supply, tables
from pipeline.panel import curves
from pipeline.panel.agreement import agreement
from pipeline.panel.records import Panel, PanelCurveSettings
from pipeline.panel.single_diode import fit


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Fit the panel's five parameters and draw its curves over irradiance and temperature."""
    panel = Panel.model_validate(settings["panel"])
    diode = fit(panel)
    lines, points = curves.curves(panel, diode, PanelCurveSettings.model_validate(settings["curves"]))
    tables.write(schemas.PANEL_PARAMETERS, curves.parameters(panel, diode), output / "parameters.parquet")
    tables.write(schemas.PANEL_CURVES, lines, output / "curves.parquet")
    tables.write(schemas.PANEL_POINTS, points, output / "points.parquet")
    tables.write(schemas_supply.PANEL_FIT, agreement(panel, diode), output / "fit.parquet")
