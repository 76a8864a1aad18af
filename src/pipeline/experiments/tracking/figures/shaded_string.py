"""The curve of a string in partial shadow, and where each tracker ends on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.experiments.tracking.figures._titles import titles
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
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
    The figure, below each curve what share of the highest power the ends come to; it says so where no trackers were
    tried.
    """
    drawing = style.figure(4.9)
    if "tracking" not in data.inputs:
        style.nothing(drawing.subplots(), "no trackers were tried", "Panel voltage [V]", "Panel power [W]")
        return drawing
    curves, ends = data.table("tracking", "shading_curves"), data.table("tracking", "shading_ends")
    scenes, names = list(dict.fromkeys(curves["scene"])), titles(data)
    rows = drawing.subplots(2, len(scenes), sharey="row", squeeze=False, height_ratios=(2.0, 1.0))
    marks = style.marks(list(names))
    for (axes, shares), scene in zip(rows.T, scenes, strict=True):
        own = curves["scene"] == scene
        axes.plot(curves["voltage_v"][own], curves["power_w"][own], color=style.GREY, linewidth=1.2)
        best = float(ends["best_w"][ends["scene"] == scene][0])
        axes.axhline(best, color=style.GREY, linewidth=0.7, linestyle=":")
        for place, (name, mark) in enumerate(marks.items()):
            at = (ends["scene"] == scene) & (ends["tracker"] == name)
            axes.plot(
                ends["voltage_v"][at], ends["power_w"][at], linestyle="", marker=mark.marker, color=mark.colour,
                markerfacecolor="none", markersize=5.0 + 2.0 * (len(marks) - 1 - place), markeredgewidth=1.3,
            )  # fmt: skip
            _share(shares, place, 100.0 * ends["power_w"][at] / best, mark)
        axes.set_title(str(scene).replace("_", " ").capitalize())
        axes.set_xlabel("Panel voltage [V]")
        axes.set_ylim(bottom=0.0)
        shares.set_xlabel("Of the highest power [%]")
        shares.set_xlim(0.0, 125.0)
        shares.set_xticks([0, 50, 100])
        shares.grid(False, axis="y")
    rows[0, 0].set_ylabel("Panel power [W]")
    rows[1, 0].set_yticks(range(len(names)), list(dict(names).values()), fontsize=8)
    rows[1, 0].set_ylim(len(names) - 0.5, -0.5)
    return drawing


def _share(axes: Axes, place: int, percent: np.ndarray, mark: style.Mark) -> None:
    for value in percent:
        axes.plot([0.0, value], [place, place], color=mark.colour, linewidth=1.2)
        axes.plot(value, place, marker=mark.marker, color=mark.colour, markersize=5)
        axes.text(value, place, f"  {value:.0f}", va="center", fontsize=8)
