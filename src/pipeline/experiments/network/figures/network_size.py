"""Error of the network against the number of its centres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.experiments.network.figures.strings import METHODS
from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network_size",)


class Options(Record):
    """The errors by size, beside the one that the paper prints."""

    published_units: int | None = Field(default=None, gt=0, description="processing units of the paper's network")
    published_mse: float | None = Field(default=None, gt=0, description="error that the paper prints for it")


# Errors below this are rounding: the network meets every point.
_LEAST = 1e-8


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw every replicate, the medians, and forward selection.

    Arguments
    ---------
    figure : the card.
    data : the errors by number of centres.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table("network_size", "sizes")
    centres, error = table["centres"].astype(int), np.maximum(table["mse"].astype(float), _LEAST)
    drawing = style.figure(4.0)
    axes = drawing.subplots()
    for mark, method, label in (
        (style.MARKS[0], "genetic", f"{METHODS['genetic']}, median"),
        (style.MARKS[1], "forward", "forward selection"),
    ):
        own = table["method"] == method
        counts = np.unique(centres[own])
        medians = [float(np.median(error[own & (centres == count)])) for count in counts]
        axes.plot(counts, medians, color=mark.colour, linestyle=mark.line, label=label)
        seen = own & (error > _LEAST)
        axes.plot(
            centres[seen], error[seen], mark.marker, color=mark.colour, markersize=4, alpha=0.6, markeredgewidth=0
        )
    axes.set(xlabel="Centres", ylabel="Mean square error [(C-rate)²]", yscale="log")
    if np.any(error <= _LEAST):
        axes.axhspan(0.2 * _LEAST, 3.0 * _LEAST, color=style.SHADE, alpha=0.55, linewidth=0, zorder=0)
        axes.text(
            0.99, 5.0 * _LEAST, "below: rounding, the network meets every point", fontsize=8.5, ha="right",
            color=style.INK, transform=axes.get_yaxis_transform(),
        )  # fmt: skip
        axes.set_ylim(bottom=0.2 * _LEAST)
    ticks = np.unique(centres)[::2]
    units = dict(zip(centres.tolist(), table["units"].tolist(), strict=True))
    axes.set_xticks(ticks)
    _published(axes, options, units)
    above = axes.secondary_xaxis("top")
    above.set_xticks(ticks, [f"{units[count]}" for count in ticks.tolist()])
    above.set_xlabel("Processing units")
    axes.legend(loc="upper right")
    return drawing


def _published(axes: Axes, options: Options, units: dict[int, int]) -> None:
    found = [count for count, number in units.items() if number == options.published_units]
    if options.published_mse is None or not found:
        return
    axes.plot(found[:1], [options.published_mse], **style.PUBLISHED_POINT)
    axes.annotate(
        f"published: {options.published_mse:g}\nwith {options.published_units} units",
        (found[0], options.published_mse),
        xytext=(0, -8), textcoords="offset points", ha="center", color=style.PUBLISHED, fontsize=9, va="top",
    )  # fmt: skip
