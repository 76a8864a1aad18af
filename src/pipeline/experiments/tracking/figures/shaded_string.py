"""The curve of a string in partial shadow, and where each tracker ends on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.experiments.tracking.figures._titles import titles
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("tracking",)
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw power over voltage, a field for each scene, with a symbol for the end of each tracker.

    Arguments
    ---------
    figure : the card.
    data : curves and ends.

    Returns
    -------
    The figure; it says so where no trackers were tried.
    """
    drawing = style.figure(3.6)
    if "tracking" not in data.inputs:
        style.nothing(drawing.subplots(), "no trackers were tried", "Panel voltage [V]", "Panel power [W]")
        return drawing
    curves, ends = data.table("tracking", "shading_curves"), data.table("tracking", "shading_ends")
    scenes, names = list(dict.fromkeys(curves["scene"])), titles(data)
    fields = drawing.subplots(1, len(scenes), sharey=True, squeeze=False)[0]
    marks = style.marks(list(names))
    for axes, scene in zip(fields, scenes, strict=True):
        own = curves["scene"] == scene
        axes.plot(curves["voltage_v"][own], curves["power_w"][own], color=style.GREY, linewidth=1.2)
        for name, mark in marks.items():
            at = (ends["scene"] == scene) & (ends["tracker"] == name)
            axes.plot(
                ends["voltage_v"][at], ends["power_w"][at], linestyle="", marker=mark.marker, color=mark.colour,
                markeredgecolor="white", markersize=8,
            )  # fmt: skip
        best = float(ends["best_w"][ends["scene"] == scene][0])
        axes.axhline(best, color=style.GREY, linewidth=0.7, linestyle=":")
        axes.set_title(str(scene).replace("_", " ").capitalize())
        axes.set_xlabel("Panel voltage [V]")
        axes.set_ylim(bottom=0.0)
    fields[0].set_ylabel("Panel power [W]")
    shown = style.handles(dict(names), marks)
    for handle in shown:
        handle.set_linestyle("")
    drawing.legend(handles=shown, loc="outside upper center", ncols=3)
    return drawing
