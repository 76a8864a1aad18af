"""What the engine is off a closed form or another code, over time."""

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


FLOOR = 1e-17
"""What is smaller is drawn here: a difference of exactly zero has no logarithm."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the magnitude of every line of a check over time, a field for each group.

    Arguments
    ---------
    figure : the card; its options name the check.
    data : the curves of the check.

    Returns
    -------
    The figure; it says so where the other code is not installed.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table(f"validation/{options.check}", "curves")
    groups = list(dict.fromkeys(map(str, table["group"])))
    if not groups:
        drawing = style.figure(1.2)
        axes = drawing.subplots()
        axes.set_axis_off()
        style.nothing(axes, "not installed here: nothing was compared")
        return drawing
    rows = -(-len(groups) // options.columns)
    drawing = style.figure(0.5 + 2.0 * rows)
    fields = drawing.subplots(rows, options.columns, squeeze=False)
    found = style.marks(list(dict.fromkeys(map(str, table["series"]))))
    for axes, group in zip(fields.flat, groups, strict=False):
        _field(axes, table, group, found)
    for axes in fields.flat[len(groups) :]:
        axes.set_axis_off()
    style.legend(drawing, {name: name for name in found}, found)
    return drawing


def _field(axes: Axes, table: Columns, group: str, found: dict[str, style.Mark]) -> None:
    own = table["group"] == group
    for series in dict.fromkeys(map(str, table["series"][own])):
        rows = own & (table["series"] == series)
        mark = found[series]
        axes.plot(
            table["x"][rows],
            np.maximum(np.abs(table["y"][rows]), FLOOR),
            color=mark.colour,
            linestyle=mark.line,
            linewidth=1.2,
            label=series,
        )
    axes.set_yscale("log")
    axes.set_title(group)
    axes.set_xlabel(sentence(str(table["across"][own][0])))
    axes.set_ylabel(sentence(str(table["up"][own][0])))
