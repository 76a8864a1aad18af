"""How an error falls with the length of steps and with the tolerance, and the slopes fitted to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("validation",)


class Options(Record):
    """The lines of a check of the engine."""

    check: str = Field(min_length=1, description="name of the check")
    columns: int = Field(default=2, ge=1, le=4, description="fields in a row")


_ROUNDING = 1e-14


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw error over length and over tolerance, both logarithmic, with the fitted straight line of each driver.

    Arguments
    ---------
    figure : the card; its options name the check.
    data : the curves of the check.
    """
    from matplotlib.ticker import NullFormatter

    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table(f"validation/{options.check}", "curves")
    groups = list(dict.fromkeys(map(str, table["group"])))
    drawing = style.figure(3.4)
    fields = drawing.subplots(1, len(groups), squeeze=False, sharey=True)
    found = style.marks(list(dict.fromkeys(map(str, table["series"]))))
    for axes, group in zip(fields.flat, groups, strict=True):
        for series, mark in found.items():
            _line(axes, table, (table["group"] == group) & (table["series"] == series), series, mark)
        axes.set_xscale("log")
        axes.set_yscale("log")
        across = str(table["across"][table["group"] == group][0])
        axes.set_xlabel(sentence(across).removesuffix(" [1]"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc="lower right")
    fields[0, 0].set_ylabel("Relative error")
    return drawing


def _line(axes: Axes, table: Columns, rows: np.ndarray, series: str, mark: style.Mark) -> None:
    x, y = table["x"][rows], table["y"][rows]
    axes.plot(x, y, color=mark.colour, marker=mark.marker, linestyle="", label=series)
    kept = y > _ROUNDING
    if np.count_nonzero(kept) > 1:
        slope, level = np.polyfit(np.log(x[kept]), np.log(y[kept]), 1)
        axes.plot(
            x,
            np.exp(level) * x**slope,
            color=mark.colour,
            linestyle=mark.line,
            linewidth=1.0,
            label=f"{series}: power {slope:.2f}",
        )
