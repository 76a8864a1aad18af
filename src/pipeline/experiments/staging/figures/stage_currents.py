"""Currents and temperature rise over the state of charge, for each pair of weights and as printed (Figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("staging",)


class Options(Record):
    """Staged charges that matter."""

    cases: dict[str, str] = Field(min_length=1, max_length=7, description="name of a case -> what it is called here")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the current of each stage on the left, the rise at its end on the right.

    Arguments
    ---------
    figure : the card; its options name the cases and what they are called.
    data : the staged charges that matter.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    stages, cases = data.table("staging", "currents"), data.table("staging", "cases")
    drawing = style.figure(4.4)
    current, rise = drawing.subplots(1, 2)
    titles, seen = {}, {}
    for place, ((name, title), mark) in enumerate(zip(options.cases.items(), style.MARKS, strict=False)):
        rows = stages["case"] == name
        if not rows.any():
            continue
        edges = np.append(stages["soc_from"][rows], stages["soc_to"][rows][-1]) * 100.0
        current.stairs(
            stages["current_a"][rows], edges, color=mark.colour, linestyle=mark.line, linewidth=1.8, baseline=None
        )
        rise.plot(
            edges, np.append(0.0, stages["rise_k"][rows]), color=mark.colour, linestyle=mark.line, marker=mark.marker,
            markevery=slice(1, None), markersize=5.0 + 1.5 * min(4, len(options.cases) - 1 - place),
        )  # fmt: skip
        time = float(cases["time_s"][cases["case"] == name][0])
        peak = float(cases["peak_k"][cases["case"] == name][0])
        titles[name], seen[name] = f"{title}: {time:.0f} s, {peak:.2f} K", mark
    for axes, label in ((current, "Current [A]"), (rise, "Temperature rise at the end of the stage [K]")):
        axes.set_ylabel(label)
        axes.set_xlabel("State of charge [%]")
        axes.set_ylim(bottom=0.0)
    style.above(drawing, style.handles(titles, seen), size=10.0)
    return drawing
