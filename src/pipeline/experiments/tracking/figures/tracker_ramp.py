"""The course of a fast ramp of the irradiance under each tracker."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.experiments.tracking.figures._titles import titles
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("tracking",)
Options = NoOptions


_SMALLEST_W = 0.05
"""Where the logarithmic axis of what is not captured begins."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw power and voltage of the panel over time, a line for each tracker.

    Arguments
    ---------
    figure : the card.
    data : the course of the ramp.

    Returns
    -------
    The figure; it says so where no trackers were tried.
    """
    drawing = style.figure(5.6)
    fields = drawing.subplots(3, 1, sharex=True, height_ratios=(1.6, 1.6, 1.2))
    fields[0].set_ylabel("Panel power [W]")
    fields[1].set_ylabel("Not captured [W]")
    fields[2].set_ylabel("Panel voltage [V]")
    fields[2].set_xlabel("Time [s]")
    if "tracking" not in data.inputs:
        for axes in fields:
            style.nothing(axes, "no trackers were tried")
        return drawing
    found, names = data.table("tracking", "course"), titles(data)
    marks = style.marks(list(names))
    for later, (name, mark) in zip(range(len(marks) - 1, -1, -1), marks.items(), strict=True):
        own = {key: column[found["tracker"] == name] for key, column in found.items()}
        look = {"color": mark.colour, "linestyle": mark.line, "linewidth": 1.0 + 0.4 * later}
        fields[0].plot(own["time_s"], own["power_w"], **look)
        fields[1].plot(own["time_s"], np.maximum(own["available_w"] - own["power_w"], _SMALLEST_W), **look)
        fields[2].plot(own["time_s"], own["voltage_v"], **look)
    fields[1].set_yscale("log")
    fields[1].set_ylim(bottom=_SMALLEST_W)
    first = found["tracker"] == next(iter(names))
    fields[0].plot(
        found["time_s"][first], found["available_w"][first], color=style.GREY, linewidth=0.8, label="_reference"
    )
    fields[0].annotate(
        "available", (0.0, 1.0), xycoords="axes fraction", xytext=(4, -12), textcoords="offset points", color=style.GREY
    )
    style.above(drawing, style.handles(dict(names), marks, False), size=10.0)
    return drawing
