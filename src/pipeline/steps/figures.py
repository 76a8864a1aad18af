"""Figures: one figure card and the artefacts it reads in; the figure as SVG and PNG out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.report.draw import draw
from pipeline.report.records import FigureCard
from pipeline.steps.labels import report_data


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Draw the figure."""
    data = report_data(settings, inputs)
    draw(settings["id"], FigureCard.model_validate(settings["card"]), data, output)
