"""Figures: one figure card and the artefacts it reads in; the figure as SVG and PNG out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.kernel.artefacts import Inputs, Output
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import report_data


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Draw the figure and write it."""
    card = FigureCard.model_validate(settings["card"])
    with style.active():
        style.save(card.drawing().draw(card, report_data(settings, inputs)), output.folder, settings["id"])
