"""Chaotic, uniform and arcsine random numbers in the same search: how soon, how near, and whether it differs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("search",)


class Options(Record):
    """Searches held against each other."""

    searches: dict[str, str] = Field(min_length=2, description="name of a search -> what it is called here")


_MEASURES = {
    "iterations_to_within_1_hz": ("Iterations to within 1 Hz", "needs more iterations"),
    "final_distance_hz": ("Final distance from the best [Hz]", "ends farther off"),
}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the mean of each search by both measures, and the effect size of each pair.

    Arguments
    ---------
    figure : the card; its options name the searches.
    data : the searches' statistics and comparison.

    Returns
    -------
    The figure, all with 95 % intervals.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    pairs = _pairs(data, options.searches)
    drawing = style.figure(1.5 + 0.32 * (len(options.searches) + len(pairs)) + 1.0)
    rows = drawing.subplots(
        2, len(_MEASURES), height_ratios=(len(options.searches) + 0.6, max(len(pairs), 1) + 0.6), squeeze=False
    )
    for column, (measure, (label, worse)) in enumerate(_MEASURES.items()):
        _means(rows[0, column], data, measure, options.searches, label)
        _effects(rows[1, column], data, measure, pairs, options.searches, f"Chance that the first {worse}")
        if column:
            for axes in rows[:, column]:
                axes.tick_params(labelleft=False)
    return drawing


def _pairs(data: ReportData, searches: dict[str, str]) -> list[tuple[str, str]]:
    table = data.table("search", "comparison")
    found = dict.fromkeys(zip(table["first"].tolist(), table["second"].tolist(), strict=True))
    return [pair for pair in found if set(pair) <= set(searches)]


def _means(axes: Axes, data: ReportData, measure: str, searches: dict[str, str], label: str) -> None:
    table = data.table("search", "statistics")
    for place, (name, mark) in enumerate(zip(searches, style.MARKS, strict=False)):
        row = (table["search"] == name) & (table["measure"] == measure)
        if row.any():
            value, low, high = (float(table[part][row][0]) for part in ("mean", "mean_low", "mean_high"))
            _interval(axes, place, value, low, high, mark)
    axes.margins(x=0.06)
    axes.set_xlim(left=0.0)
    _named(axes, list(searches.values()), label)


def _effects(
    axes: Axes, data: ReportData, measure: str, pairs: list[tuple[str, str]], searches: dict[str, str], label: str
) -> None:
    table = data.table("search", "comparison")
    for place, (first, second) in enumerate(pairs):
        row = (table["first"] == first) & (table["second"] == second) & (table["measure"] == measure)
        low, high = float(table["larger_low"][row][0]), float(table["larger_high"][row][0])
        mark = style.MARKS[3] if low <= 0.5 <= high else style.MARKS[2]
        _interval(axes, place, float(table["larger"][row][0]), low, high, mark)
    axes.axvline(0.5, color=style.GREY, linewidth=1.0, linestyle=":")
    axes.set_xlim(0.2, 0.8)
    _named(axes, [f"{searches[first]} over {searches[second]}" for first, second in pairs], label)


def _interval(axes: Axes, place: int, value: float, low: float, high: float, mark: style.Mark) -> None:
    if np.isfinite(value):
        axes.plot([low, high], [place, place], color=mark.colour, linewidth=2.0)
        axes.plot(value, place, mark.marker, color=mark.colour, markersize=7)


def _named(axes: Axes, names: list[str], label: str) -> None:
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.grid(False, axis="y")
    axes.set_xlabel(label)
