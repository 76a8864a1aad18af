"""How searches converge on test functions, with the minimum at the origin and elsewhere (Figures 5 and 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from pipeline.experiments.functions.figures._parts import FLOOR, NAMES, PLACES, floored, rows_of, value_ticks
from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("functions",)


class Options(Record):
    """Searches on test functions, run by run."""

    functions: tuple[str, ...] = Field(min_length=1, description="names of the functions, a column each")
    placements: tuple[Literal["centred", "shifted", "rotated"], ...] = Field(
        default=("centred", "shifted", "rotated"), min_length=1, description="a row each"
    )
    searches: dict[str, str] = Field(min_length=1, description="name of a search -> what it is called here")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the median run of each search, and the middle half of the runs as a band.

    Arguments
    ---------
    figure : the card; its options choose functions, placements and searches.
    data : the curves of the function study.

    Returns
    -------
    The figure: a row for each placement, a column for each function.
    """
    from matplotlib.ticker import NullLocator

    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table("functions", "curves")
    drawing = style.figure(0.7 + 1.9 * len(options.placements))
    fields = drawing.subplots(len(options.placements), len(options.functions), sharex=True, sharey=True, squeeze=False)
    found = style.marks(list(options.searches))
    for row, placement in enumerate(options.placements):
        for column, function in enumerate(options.functions):
            axes = fields[row, column]
            for search, mark in found.items():
                _curve(axes, table, (function, placement, search), mark)
            axes.set_title(NAMES.get(function, function) if row == 0 else "")
        fields[row, 0].set_ylabel(f"{PLACES[placement]}\nbest value so far [1]")
    largest = max(float(np.max(table["high"][table["function"] == function])) for function in options.functions)
    last = int(np.max(table["generation"][np.isin(table["search"], list(options.searches))]))
    for axes in fields.flat:
        axes.set_yscale("log")
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_xlim(0.0, last)
        axes.set_xticks([0, *(10**power for power in range(1 + int(np.log10(max(last, 1)))))], minor=False)
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_ylim(0.2 * FLOOR, 5.0 * largest)
        value_ticks(axes.yaxis)
    for axes in fields[-1]:
        axes.set_xlabel("Generation [1]")
    style.legend(drawing, options.searches, found)
    return drawing


def _curve(axes: Axes, table: Columns, names: tuple[str, str, str], mark: style.Mark) -> None:
    rows = rows_of(table, *names)
    generation = table["generation"][rows]
    low, median, high = (floored(table[name][rows]) for name in ("low", "median", "high"))
    axes.fill_between(generation, low, high, color=mark.colour, alpha=0.15, linewidth=0)
    axes.plot(generation, median, color=mark.colour, linestyle=mark.line, linewidth=1.4)
    axes.axhline(FLOOR, color=style.GREY, linewidth=0.6, linestyle=":")
