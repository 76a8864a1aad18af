"""Every way to select the centres, a point for each replicate, with the errors the paper prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.experiments.network.figures.strings import METHODS
from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network",)


class Options(Record):
    """The selections, beside the errors that the paper prints."""

    published: dict[str, float] = Field(
        default_factory=dict, description="name of a selection or of a network -> the error that the paper prints"
    )


# Zero cannot be drawn on a logarithmic axis; errors below this are rounding.
_LEAST = 1e-8
_TITLES = METHODS | {"anfis": "ANFIS", "grnn": "GRNN [7] of the paper"}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the error of every selection, a row per method.

    Arguments
    ---------
    figure : the card.
    data : the selections, and the neuro-fuzzy system's error.
    """
    from matplotlib.lines import Line2D

    options = figure.chosen()
    assert isinstance(options, Options)
    table, found = data.table("network", "selections"), data.numbers("network")
    names = [str(name) for name in dict.fromkeys(table["method"])]
    drawing = style.figure(1.3 + 0.36 * (len(names) + 1))
    axes = drawing.subplots()
    for place, name in enumerate(names):
        values = np.maximum(table["mse"][table["method"] == name].astype(float), _LEAST)
        colour = style.MARKS[0].colour if name == "genetic" else style.GREY
        spread = np.linspace(-0.24, 0.24, len(values)) if len(values) > 1 else np.zeros(1)
        axes.plot(
            values,
            place + spread,
            "o",
            color=colour,
            markersize=3.5 if len(values) > 1 else 6,
            alpha=0.6,
            markeredgewidth=0,
        )
        if len(values) > 1:
            axes.plot(np.median(values), place, "|", color=colour, markersize=16, markeredgewidth=2.2)
    axes.plot(found["anfis_mse"], len(names), "D", color=style.MARKS[2].colour, markersize=6)
    rows = [*names, *(name for name in {"anfis": None, **options.published} if name not in names)]
    for name, value in options.published.items():
        axes.plot(value, rows.index(name), **style.PUBLISHED_POINT)
        axes.annotate(
            f"{value:g}", (value, rows.index(name)), xytext=(0, -8), textcoords="offset points", ha="center", va="top",
            color=style.PUBLISHED, fontsize=8,
        )  # fmt: skip
    axes.set_yticks(range(len(rows)), [_TITLES.get(name, name.replace("_", " ")) for name in rows])
    axes.set(xscale="log", xlabel="Mean square error over the data [(C-rate)²]")
    axes.set_ylim(len(rows) - 0.2, -0.6)
    axes.set_xmargin(0.08)
    keys = [
        Line2D([], [], color=style.GREY, marker="o", markersize=3.5, linestyle="", label="a run"),
        Line2D([], [], color=style.GREY, marker="|", markersize=14, markeredgewidth=2.2, linestyle="", label="median"),
        Line2D([], [], color=style.MARKS[2].colour, marker="D", linestyle="", label="neuro-fuzzy system, trained once"),
        Line2D([], [], label="published", **style.PUBLISHED_POINT),
    ]
    style.above(drawing, keys if options.published else keys[:-1])
    return drawing
