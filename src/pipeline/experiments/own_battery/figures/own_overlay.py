"""Measured and simulated voltage, current and temperature over each other, with what is left between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData

READS = ("own_fit",)


class Options(Record):
    """Which file is drawn."""

    file: int = Field(default=0, ge=0, description="number of the file, from 0 [1]")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw voltage, its residuals, current and temperature over time; what was held out lies on grey."""
    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table("own_fit", "overlay")
    own = table["file"] == options.file
    rows = {name: values[own] for name, values in table.items()}
    drawing = style.figure(8.0)
    fields = drawing.subplots(4, 1, sharex=True, height_ratios=(3, 2, 1.5, 2))
    if not own.any():
        style.nothing(fields[0], "the run has no such file")
        return drawing
    hours = rows["time_s"] / 3600.0
    measured, simulated = style.MARKS[3], style.MARKS[0]
    out = rows["held_out"].astype(bool)
    for axes in fields:
        _shade(axes, hours, out)
    fields[0].plot(hours, rows["measured_v"], color=measured.colour, linewidth=2.2, label="measured")
    fields[0].plot(hours, rows["simulated_v"], color=style.MARKS[1].colour, linewidth=1.0, label="simulated")
    fields[0].set_ylabel("Voltage [V]")
    missed = 1e3 * (rows["simulated_v"] - rows["measured_v"])
    fields[1].plot(hours, missed, color=simulated.colour, linewidth=0.9)
    reach = max(1.0, 1.5 * float(np.percentile(np.abs(missed), 98)))
    fields[1].set(ylabel="Simulated less\nmeasured [mV]", ylim=(-reach, reach))
    fields[1].axhline(0.0, color=style.GREY, linewidth=0.8)
    fields[2].plot(hours, rows["current_a"], color=measured.colour, linewidth=1.0)
    if not np.array_equal(rows["current_a"], rows["simulated_a"]):
        fields[2].plot(hours, rows["simulated_a"], color=style.MARKS[1].colour, linewidth=1.0)
    fields[2].set_ylabel("Current [A]")
    warm = np.array([np.nan if value is None else value for value in rows["measured_c"].tolist()], dtype=float)
    if not np.isnan(warm).all():
        fields[3].plot(hours, warm, color=measured.colour, linewidth=2.0)
    fields[3].plot(hours, rows["simulated_c"], color=style.MARKS[1].colour, linewidth=1.0)
    fields[3].set(ylabel="Temperature [°C]", xlabel="Time [h]")
    handles, labels = fields[0].get_legend_handles_labels()
    if out.any():
        from matplotlib.patches import Patch

        handles, labels = [*handles, Patch(color="#dddddd")], [*labels, "held out"]
    drawing.legend(handles, labels, loc="outside upper center", ncols=3)
    return drawing


def _shade(axes: Axes, hours: Any, out: Any) -> None:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], out.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        axes.axvspan(hours[begin], hours[min(end, len(hours) - 1)], color="#dddddd", linewidth=0)
