"""Where the replicates of two searches stand in time and rise, early and at the end: the paper's headline."""

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


READS = ("staging_search", "staging")


class Options(Record):
    """Searches for stage currents."""

    weights: str = Field(min_length=1, description="name of the weights")
    searches: dict[str, str] = Field(min_length=1, max_length=7, description="name of a search -> what it is called")
    published_saved: float | None = Field(
        default=None, gt=0, lt=1, description="share of the first search's time that the others save in the paper"
    )


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw time and rise of every replicate, at a tenth of the charges and at all of them.

    Arguments
    ---------
    figure : the card; its options name weights and searches.
    data : the searches' runs.
    """
    from matplotlib.lines import Line2D

    options = figure.chosen()
    assert isinstance(options, Options)
    numbers = data.numbers("staging")
    drawing = style.figure(4.2)
    fields = drawing.subplots(1, 2)
    titles, seen = {}, {}
    for (name, title), mark in zip(options.searches.items(), style.MARKS, strict=False):
        source = f"staging_search/{options.weights}/{name}"
        if source not in data.inputs:
            continue
        runs = data.table(source, "runs")
        for axes, early in zip(fields, ("early_", ""), strict=True):
            _cloud(axes, runs[f"{early}time_s"], runs[f"{early}peak_k"], mark)
        titles[name], seen[name] = title, mark
        if options.published_saved is not None and len(seen) == 1:
            for axes, early in zip(fields, ("early_", ""), strict=True):
                time_s = (1.0 - options.published_saved) * float(np.mean(runs[f"{early}time_s"]))
                words = f"published: {100 * options.published_saved:g} % less\nthan the mean of {title}"
                axes.margins(0.06)
                style.published(axes, time_s, "" if early else words, upright=True, at=0.12)
    for axes, count, words in zip(fields, ("early_evaluations", "evaluations"), ("", ", enlarged"), strict=True):
        axes.set_title(f"after {numbers[count]:.0f} charges{words}")
        axes.set_xlabel("Charging time found [s]")
    for axes in fields:
        axes.margins(0.06)
    fields[0].set_ylabel("Highest temperature rise [K]")
    keys = []
    for name, mark in seen.items():
        keys += [Line2D([], [], label=titles[name], color=mark.colour, marker=mark.marker, linestyle="")]
        keys += [Line2D([], [], color=mark.colour, label=f"mean of {titles[name]}", **_mean(mark))]
    style.above(drawing, keys, size=10.0)
    return drawing


def _mean(mark: style.Mark) -> dict[str, Any]:
    return {"marker": mark.marker, "markersize": 12, "markerfacecolor": "none", "markeredgewidth": 2.0, "linestyle": ""}


def _cloud(axes: Axes, time: np.ndarray, rise: np.ndarray, mark: style.Mark) -> None:
    axes.plot(time, rise, mark.marker, color=mark.colour, markersize=5, alpha=0.55, linestyle="", markeredgewidth=0)
    axes.plot([time.mean()], [rise.mean()], color=mark.colour, **_mean(mark))
