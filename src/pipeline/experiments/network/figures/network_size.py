"""Error of the network against the number of its centres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network_size",)
Options = NoOptions
# Errors below this are rounding: the network meets every point.
_LEAST = 1e-8


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw every replicate, the medians, and forward selection.

    Arguments
    ---------
    figure : the card.
    data : the errors by number of centres.
    """
    table = data.table("network_size", "sizes")
    centres, error = table["centres"].astype(int), np.maximum(table["mse"].astype(float), _LEAST)
    drawing = style.figure(4.0)
    axes = drawing.subplots()
    for mark, method, label in (
        (style.MARKS[0], "genetic", "genetic algorithm, median"),
        (style.MARKS[1], "forward", "forward selection"),
    ):
        own = table["method"] == method
        counts = np.unique(centres[own])
        medians = [float(np.median(error[own & (centres == count)])) for count in counts]
        axes.plot(counts, medians, color=mark.colour, linestyle=mark.line, label=label)
        axes.plot(centres[own], error[own], mark.marker, color=mark.colour, markersize=4, alpha=0.6, markeredgewidth=0)
    axes.set(xlabel="Centres", ylabel="Mean square error [C²]", yscale="log")
    ticks = np.unique(centres)[::2]
    units = dict(zip(centres.tolist(), table["units"].tolist(), strict=True))
    axes.set_xticks(ticks)
    above = axes.secondary_xaxis("top")
    above.set_xticks(ticks, [f"{units[count]}" for count in ticks.tolist()])
    above.set_xlabel("Processing units")
    axes.legend(loc="lower left")
    return drawing
