"""How far above the best the searches for stage currents are, over the charges they compute."""

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


READS = ("staging_search", "staging")


class Options(Record):
    """Searches for stage currents."""

    weights: str = Field(min_length=1, description="name of the weights")
    searches: dict[str, str] = Field(min_length=1, max_length=7, description="name of a search -> what it is called")


_FLOOR = 1e-8


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the median and quartiles of each search's excess over the local solver's optimum.

    Arguments
    ---------
    figure : the card; its options name weights and searches.
    data : the searches' courses, and the best objective there is.
    """
    from matplotlib.patches import Patch

    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(4.6)
    axes = drawing.subplots()
    best = data.numbers("staging")[f"{options.weights}_best_value"]
    ends: list[tuple[float, str, str]] = []
    for (name, title), mark in zip(options.searches.items(), style.MARKS, strict=False):
        source = f"staging_search/{options.weights}/{name}"
        if source not in data.inputs:
            continue
        course = data.table(source, "course")
        low, median, high = (np.maximum(course[part] / best - 1.0, _FLOOR) for part in ("low", "median", "high"))
        axes.fill_between(course["evaluations"], low, high, color=mark.colour, alpha=0.13, linewidth=0)
        axes.plot(course["evaluations"], median, color=mark.colour, linestyle=mark.line)
        ends.append((float(median[-1]), title, mark.colour))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("Charges computed")
    axes.set_ylabel("Objective above the best there is, as a share of it")
    if ends:
        axes.margins(x=0.0)
        style.at_ends(axes, ends, apart=0.07)
    key = Patch(facecolor=style.GREY, alpha=0.3, label="quartiles about each median")
    axes.legend(handles=[key], loc="lower left", fontsize=9)
    return drawing
