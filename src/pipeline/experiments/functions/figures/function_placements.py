"""What becomes of a perfect score when the minimum leaves the origin."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
    """Searches on test functions, by where the minimum is."""

    searches: dict[str, str] = Field(min_length=1, description="name of a search -> what it is called here")
    published_goal: float | None = Field(
        default=None, gt=0, description="value at which the paper counts a run as done"
    )


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the mean best value of each search on each function, a symbol for each placement.

    Arguments
    ---------
    figure : the card; its options choose the searches.
    data : the statistics of the function study.

    Returns
    -------
    The figure: a field for each search, with the share of successful runs over all functions in its title.
    """
    from matplotlib.lines import Line2D

    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table("functions", "statistics")
    functions = list(dict.fromkeys(table["function"].tolist()))
    placements = [place for place in PLACES if place in set(table["placement"].tolist())]
    numbers = data.numbers("functions")
    drawing = style.figure(1.6 + 0.42 * len(functions))
    fields = drawing.subplots(1, len(options.searches), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (search, title) in zip(fields, options.searches.items(), strict=True):
        for place, function in enumerate(functions):
            _line(axes, table, place, [(function, placement, search) for placement in placements])
        shares = (numbers.get(f"{search}_{placement}_mean_success_share", 0.0) for placement in placements)
        axes.set_title(title + "\n" + " / ".join(f"{100 * share:.0f}" for share in shares) + " % succeed")
        axes.set_xscale("log")
        axes.set_xlim(0.1 * FLOOR, 1e3)
        value_ticks(axes.xaxis)
        if options.published_goal is not None:
            style.published(axes, options.published_goal, "", upright=True)
        axes.set_xlabel("Mean best value")
    fields[0].set_yticks(range(len(functions)), [NAMES.get(name, name) for name in functions])
    fields[0].set_ylim(len(functions) - 0.5, -0.5)
    handles = [
        Line2D([], [], color=mark.colour, marker=mark.marker, linestyle="", label=PLACES[placement])
        for placement, mark in zip(placements, style.MARKS, strict=False)
    ]
    if options.published_goal is not None:
        handles.append(style.key_of_published("goal of the paper"))
    style.above(drawing, handles, size=10.0)
    return drawing


def _line(axes: Axes, table: Columns, place: int, names: list[tuple[str, str, str]]) -> None:
    values = [float(floored(table["mean"][rows_of(table, *one)])[0]) for one in names]
    axes.plot([min(values), max(values)], [place, place], color=style.GREY, linewidth=0.8, zorder=1)
    for offset, (value, mark) in enumerate(zip(values, style.MARKS, strict=False)):
        axes.plot(value, place + 0.12 * (offset - 1), mark.marker, color=mark.colour, markersize=6, zorder=3)
