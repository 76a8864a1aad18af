"""What each tracker misses of ramps of the irradiance, over their slope."""

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


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the share that is not captured over the slope, a field for each group of ramps.

    Arguments
    ---------
    figure : the card.
    data : what the trackers captured of each ramp.

    Returns
    -------
    The figure; it says so where no trackers were tried.
    """
    drawing = style.figure(3.8)
    if "tracking" not in data.inputs:
        style.nothing(drawing.subplots(), "no trackers were tried", "Slope [W/m²/s]", "Not captured [%]")
        return drawing
    found, names = data.table("tracking", "ramps"), titles(data)
    groups = list(dict.fromkeys(found["group"]))
    fields = drawing.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    marks = style.marks(list(names))
    for axes, group in zip(fields, groups, strict=True):
        for later, (name, mark) in zip(range(len(marks) - 1, -1, -1), marks.items(), strict=True):
            own = (found["group"] == group) & (found["tracker"] == name)
            missed = 100.0 * np.maximum(1.0 - found["efficiency"][own], 1e-6)
            line = mark.line if np.count_nonzero(own) > 2 else ""
            axes.loglog(
                found["slope_w_m2_s"][own], missed, color=mark.colour, linestyle=line, marker=mark.marker,
                markersize=4.0 + 1.2 * later,
            )  # fmt: skip
        axes.margins(x=0.12)
        low, high = (found[f"{end}_w_m2"][found["group"] == group][0] for end in ("low", "high"))
        axes.set_title(f"{low:g} to {high:g} W/m²")
        axes.set_xlabel("Slope [W/m²/s]")
    fields[0].set_ylabel("Not captured [%]")
    style.above(drawing, style.handles(dict(names), marks), size=10.0)
    return drawing
