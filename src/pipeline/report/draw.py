"""From a card to the files of its figure."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Protocol, cast

from matplotlib.figure import Figure

from pipeline.report import style
from pipeline.report.data import ReportData
from pipeline.report.records import FigureCard


class Drawing(Protocol):
    """What every module under `figures` offers."""

    def draw(self, figure: FigureCard, data: ReportData) -> Figure:
        """Draw the card's figure from the artefacts."""
        ...


def module(card: FigureCard) -> Drawing:
    """Return the module that draws a card."""
    return cast(Drawing, importlib.import_module(f"pipeline.report.figures.{card.draw}"))


def draw(name: str, card: FigureCard, data: ReportData, folder: Path) -> list[Path]:
    """Draw one figure and write it as SVG and PNG.

    Arguments
    ---------
    name : identifier of the figure, which becomes its file name.
    card : what to draw.
    data : the artefacts.
    folder : where the files go.

    Returns
    -------
    The paths written.
    """
    with style.active():
        return style.save(module(card).draw(card, data), folder, name)
