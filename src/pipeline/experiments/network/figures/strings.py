"""The strings of the genetic algorithm: which rows of the data become centres, and where they lie (Figure 5)."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("network", "surface")
Options = NoOptions
METHODS = {
    "genetic": "genetic algorithm",
    "genetic_long": "the same, longer",
    "exchange": "exchange",
    "random_best": "best of random sets",
    "greedy": "greedy selection",
    "least_squares": "least squares",
    "medoids": "medoids",
    "random": "random points",
    "regular": "regular grid",
}
"""What the ways to select centres are called, in every figure."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the best string of each method beside the temperatures of its points.

    Arguments
    ---------
    figure : the card.
    data : the networks, and the legible rows of the paper's Table II.

    Returns
    -------
    The figure; the paper's own rows come last.
    """
    table = data.table("network", "networks")
    names = [name for name in METHODS if name in set(map(str, table["network"]))]
    drawing = style.figure(1.2 + 0.42 * (len(names) + 1))
    left, right = drawing.subplots(1, 2, sharey=True, width_ratios=[1.0, 1.15])
    for height, name in enumerate(names):
        rows = table["network"] == name
        colour = style.MARKS[0].colour if name.startswith("genetic") else "#555555"
        _string(left, height, table["row"][rows], colour)
        _points(right, height, table["temperature_c"][rows], table["rate_c"][rows], colour)
    _printed(left, right, len(names), data)
    _sizes(drawing)
    left.set_yticks(
        range(len(names) + 1), [*(METHODS[name] for name in names), "legible in Table II:\nT, dT/dt in K/min"]
    )
    left.set_ylim(len(names) + 0.6, -0.6)
    left.set_xlim(0.0, 6.0 if not len(table["centre"]) else float(table["centre"].max()))
    left.set_title("String: numbers of the points")
    left.set_xticks([])
    left.grid(False)
    left.spines[["left", "bottom"]].set_visible(False)
    left.tick_params(length=0)
    right.set_title("Their temperatures")
    right.set_xlabel("Temperature [°C]")
    return drawing


def _string(axes: Axes, height: int, rows: NDArray[np.int64], colour: str) -> None:
    for place, row in enumerate(rows.tolist()):
        axes.text(
            place + 0.5, height, f"{row}", ha="center", va="center", fontsize=9, color=colour,
            bbox={"boxstyle": "square,pad=0.35", "facecolor": "#f4f6f9", "edgecolor": colour, "linewidth": 0.8},
        )  # fmt: skip


def _points(axes: Axes, height: int, temperature: NDArray[np.float64], rate: NDArray[np.float64], colour: str) -> None:
    """Draw points at their temperatures; the few that share one stand side by side."""
    order = np.argsort(temperature, kind="stable")
    shift = np.zeros(len(order))
    for before, after in itertools.pairwise(order):
        if temperature[after] - temperature[before] < 1.0:
            shift[after] = shift[before] + 0.22
    axes.scatter(
        temperature, height + shift - shift.max() / 2, s=_size(rate), color=colour, edgecolor="white", zorder=3
    )


def _size(rate: Any) -> Any:
    """Return the area of the symbol of a rate [points²]."""
    return 14.0 + 11.0 * rate


def _sizes(drawing: Figure) -> None:
    """Tell the size of a symbol for some rates."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            linestyle="",
            marker="o",
            color="#555555",
            markersize=float(np.sqrt(_size(rate))),
            label=f"{rate:g}C",
        )
        for rate in (0.0, 2.0, 4.0, 8.0)
    ]
    drawing.legend(
        handles=handles, loc="outside upper right", ncols=4, fontsize=9, handlelength=1.0,
        title="size of a symbol: rate", title_fontsize=9,
    )  # fmt: skip


def _printed(left: Axes, right: Axes, height: int, data: ReportData) -> None:
    if "surface" not in data.inputs:
        return
    table = data.table("surface", "printed")
    rows = table["surface"] == table["surface"][0]
    known: Columns = {name: column[rows] for name, column in table.items()}
    _points(right, height, known["temperature_c"], known["printed_rate_c"], style.PUBLISHED)
    said = "   ".join(f"{t:g} °C, {g:g}" for t, g in zip(known["temperature_c"], known["gradient"], strict=True))
    left.text(0.05, height, said, va="center", fontsize=8.5, color=style.PUBLISHED)
