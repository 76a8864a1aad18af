"""Every way to select the centres, a point for each replicate, with the errors the paper prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network",)
Options = NoOptions
# Zero cannot be drawn on a logarithmic axis; errors below this are rounding.
_LEAST = 1e-8


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the error of every selection, a row per method.

    Arguments
    ---------
    figure : the card.
    data : the selections, and the neuro-fuzzy system's error.
    """
    table, found = data.table("network", "selections"), data.numbers("network")
    names = [str(name) for name in dict.fromkeys(table["method"])]
    drawing = style.figure(0.9 + 0.36 * (len(names) + 1))
    axes = drawing.subplots()
    for place, name in enumerate(names):
        values = np.maximum(table["mse"][table["method"] == name].astype(float), _LEAST)
        colour = style.MARKS[0].colour if name == "genetic" else style.GREY
        spread = np.linspace(-0.18, 0.18, len(values)) if len(values) > 1 else np.zeros(1)
        axes.plot(values, place + spread, "o", color=colour, markersize=3.5, alpha=0.6, markeredgewidth=0)
        axes.plot(np.median(values), place, "|", color=colour, markersize=16, markeredgewidth=2.2)
    axes.plot(found["anfis_mse"], len(names), "D", color=style.MARKS[2].colour, markersize=6)
    axes.set_yticks(range(len(names) + 1), [*(name.replace("_", " ") for name in names), "ANFIS"])
    axes.set(xscale="log", xlabel="Mean square error over the data [C²]")
    axes.set_ylim(len(names) + 0.6, -0.6)
    return drawing
