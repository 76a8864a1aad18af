"""How the search converges, run by run, with many more runs as a band behind (Figures 9 and 10)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
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
    """The course of a search."""

    quantity: Literal["frequency", "ise"]
    runs: str = Field(default="published_protocol", min_length=1, description="search whose runs are drawn one by one")
    band: str = Field(default="swarm_published", min_length=1, description="search whose runs make the band behind")
    oracle: str = Field(default="sweep", min_length=1, description="search whose end is where they should end")
    published: float | None = Field(default=None, description="where they end in the paper, in the quantity's unit")


Array = NDArray[np.float64]

_AXES = {
    "frequency": ("position", "Best frequency so far [Hz]", "Distance from brute force [Hz]", "{:.2f} Hz"),
    "ise": ("value", "Least ISE so far [mW² s]", "Excess over brute force [mW² s]", "{:.4f} mW² s"),
}
_SMALLEST = {"frequency": 1e-3, "ise": 1e-7}


class _Runs(NamedTuple):
    """Best so far of each replicate, shape (r, t), and of which iteration each column is."""

    iteration: Array
    values: Array


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the runs as published, the band of many, and where brute force ends.

    Arguments
    ---------
    figure : the card; its options choose the quantity and the two searches.
    data : the searches' histories.

    Returns
    -------
    The figure.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    column, label, distance_label, words = _AXES[options.quantity]
    drawing = style.figure(4.2)
    whole, near = drawing.subplots(1, 2, width_ratios=(1.0, 1.5))
    band, runs = _runs(data, options.band, column), _runs(data, options.runs, column)
    best = float(_runs(data, options.oracle, column).values[0, -1])
    _band(whole, band)
    _lines(whole, runs)
    whole.axhline(best, color="#222222", linewidth=1.0, linestyle=":", label=f"brute force: {words.format(best)}")
    if options.published is not None:
        end = _settled(band, runs)
        whole.plot(
            0.97 * end,
            options.published,
            label=f"published: {options.published:g} {words.split(' ', 1)[1]}",
            **style.PUBLISHED_POINT,
        )
    whole.set_ylabel(label)
    smallest = _SMALLEST[options.quantity]
    for draw_runs, one in ((_band, band), (_lines, runs)):
        draw_runs(near, one._replace(values=np.maximum(np.abs(one.values - best), smallest)))
    near.set_yscale("log")
    near.set_ylim(bottom=0.6 * smallest)
    _name_the_floor(near, smallest)
    near.set_ylabel(distance_label)
    for axes in (whole, near):
        axes.set_xlabel("Iteration")
    whole.set_xlim(0.0, _settled(band, runs))
    whole.set_title("The first iterations")
    near.set_title("All iterations")
    _legend(drawing, whole, runs)
    return drawing


def _settled(*searches: _Runs) -> float:
    """Return by when all that is seen on a linear axis has happened."""
    last = 4.0
    for runs in searches:
        low, high = np.quantile(runs.values, [0.05, 0.95], axis=0)
        wide = np.flatnonzero(high - low > 0.02 * float(np.max(high - low, initial=0.0)))
        last = max(last, float(runs.iteration[wide[-1]]) + 2.0 if len(wide) else 0.0)
    return min(last, float(searches[0].iteration[-1]))


def _name_the_floor(axes: Axes, smallest: float) -> None:
    """Say at its tick that the lowest value stands for all below it."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    powers = range(round(np.log10(smallest)), 1 + int(np.ceil(np.log10(axes.get_ylim()[1]))))
    axes.yaxis.set_major_locator(FixedLocator([10.0**power for power in powers]))
    words = [f"$10^{{{power}}}$" for power in powers]
    axes.yaxis.set_major_formatter(FixedFormatter([f"≤ {words[0]}", *words[1:]]))
    axes.yaxis.set_minor_locator(NullLocator())


def _legend(drawing: Figure, axes: Axes, runs: _Runs) -> None:
    """Tell all five styles of the runs in one entry."""
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D

    handles, labels = axes.get_legend_handles_labels()
    styles = [style.MARKS[place % len(style.MARKS)] for place in range(len(runs.values))]
    drawn = tuple(Line2D([], [], color=mark.colour, marker=mark.marker, markersize=4, linewidth=1.3) for mark in styles)
    every: list[Any] = [*handles, drawn]
    labels.append(f"{len(drawn)} runs, as published")
    style.above(drawing, every, labels, handlelength=1.8, handler_map={tuple: HandlerTuple(ndivide=None, pad=0.1)})


def _runs(data: ReportData, search: str, column: str) -> _Runs:
    table = data.table("search", f"{search}_history")
    replicates = len(np.unique(table["replicate"]))
    return _Runs(
        table["iteration"].reshape(replicates, -1)[0].astype(float), table[column].reshape(replicates, -1).astype(float)
    )


def _band(axes: Axes, runs: _Runs) -> None:
    low, high = np.quantile(runs.values, [0.05, 0.95], axis=0)
    count = len(runs.values)
    axes.fill_between(
        runs.iteration, low, high, step="post", color=style.GREY, alpha=0.22, linewidth=0,
        label=f"middle 90 % of {count} runs",
    )  # fmt: skip
    middle = np.median(runs.values, axis=0)
    axes.step(runs.iteration, middle, where="post", color=style.GREY, linewidth=1.2, label="their median")


def _lines(axes: Axes, runs: _Runs) -> None:
    for place, values in enumerate(runs.values):
        mark = style.MARKS[place % len(style.MARKS)]
        width = 1.3 + 0.5 * (len(runs.values) - 1 - place)
        axes.step(
            runs.iteration, values, where="post", color=mark.colour, linewidth=width,
            marker=mark.marker, markersize=4, markevery=(place, 5),
        )  # fmt: skip
