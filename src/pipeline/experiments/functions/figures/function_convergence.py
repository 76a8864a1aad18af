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
    from matplotlib.artist import Artist
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
    published_goal: float | None = Field(
        default=None, gt=0, description="value at which the paper counts a run as done"
    )


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
    from matplotlib.patches import Patch
    from matplotlib.ticker import NullLocator

    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table("functions", "curves")
    drawing = style.figure(0.7 + 1.9 * len(options.placements))
    fields = drawing.subplots(len(options.placements), len(options.functions), sharex=True, squeeze=False)
    found = style.marks(list(options.searches))
    for row, placement in enumerate(options.placements):
        for column, function in enumerate(options.functions):
            axes = fields[row, column]
            for later, (search, mark) in zip(range(len(found) - 1, -1, -1), found.items(), strict=True):
                _curve(axes, table, (function, placement, search), mark, 1.3 + 0.5 * min(later, 4))
            axes.set_title(NAMES.get(function, function) if row == 0 else "")
        fields[row, 0].set_ylabel(f"{PLACES[placement]}\nbest value so far")
    last = int(np.max(table["generation"][np.isin(table["search"], list(options.searches))]))
    for axes in fields.flat:
        axes.set_yscale("log")
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_xlim(0.0, last)
        axes.set_xticks([0, *(10**power for power in range(1 + int(np.log10(max(last, 1)))))], minor=False)
        axes.xaxis.set_minor_locator(NullLocator())
        low, high = _extent(axes)
        axes.set_ylim(low, high)
        if options.published_goal is not None and low < options.published_goal < high:
            style.published(axes, options.published_goal, "")
        value_ticks(axes.yaxis, low, high)
    for axes in fields[-1]:
        axes.set_xlabel("Generation")
    keys: list[Artist] = [
        *style.handles(options.searches, found, markers=False),
        Patch(facecolor=style.GREY, alpha=0.3, label="middle half of the runs"),
    ]
    if options.published_goal is not None:
        keys.append(style.key_of_published("goal of the paper"))
    style.above(drawing, keys)
    return drawing


def _curve(axes: Axes, table: Columns, names: tuple[str, str, str], mark: style.Mark, width: float) -> None:
    """Draw a search, the wider the more come later: where they coincide none hides another."""
    rows = rows_of(table, *names)
    generation = table["generation"][rows]
    low, median, high = (floored(table[name][rows]) for name in ("low", "median", "high"))
    axes.fill_between(generation, low, high, color=mark.colour, alpha=0.15, linewidth=0)
    axes.plot(generation, median, color=mark.colour, linestyle=mark.line, linewidth=width)


def _extent(axes: Axes) -> tuple[float, float]:
    """Return the limits of a field's own values: each function is shown over what it comes to."""
    values = np.concatenate(
        [np.asarray(line.get_ydata()) for line in axes.lines if len(np.atleast_1d(line.get_ydata()))]
    )
    low, high = float(np.min(values)), float(np.max(values))
    return (0.2 * FLOOR if low <= FLOOR else 0.5 * low), 3.0 * high
