"""Panel: the data sheet in; single-diode parameters, curves and their characteristic points out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.kernel.artefacts import Inputs, Output
from pipeline.panel import curves
from pipeline.panel.curves import agreement
from pipeline.panel.records import Panel, PanelCurveSettings
from pipeline.panel.single_diode import fit


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Fit the panel's five parameters and draw its curves over irradiance and temperature."""
    panel = Panel.model_validate(settings["panel"])
    diode = fit(panel)
    lines, points = curves.curves(panel, diode, PanelCurveSettings.model_validate(settings["curves"]))
    output.write("parameters", curves.parameters(panel, diode))
    output.write("curves", lines)
    output.write("points", points)
    output.write("fit", agreement(panel, diode))
