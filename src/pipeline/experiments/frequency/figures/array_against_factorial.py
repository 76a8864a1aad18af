"""The orthogonal array's choice beside all combinations of levels, and how often it finds the best of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("tuning",)
Options = NoOptions


_KNOBS = ("c1", "c2", "w")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the mean result of every combination in order, and the choices' ranks over the effort.

    Arguments
    ---------
    figure : the card.
    data : the tuning's factorial, agreement and named numbers.

    Returns
    -------
    The figure; it says so where no factorial was run.
    """
    table, numbers = data.table("tuning", "factorial"), data.numbers("tuning")
    drawing = style.figure(4.2)
    ranked, found = drawing.subplots(1, 2, width_ratios=(1.7, 1.0))
    if not len(table["mean"]):
        style.nothing(ranked, "no factorial in this run")
        style.nothing(found, "no factorial in this run")
    else:
        _ranked(ranked, table, numbers)
        _agreement(found, data.table("tuning", "agreement"), len(table["mean"]))
    ranked.set_xlabel("Rank among all combinations")
    ranked.set_ylabel("Mean result [mW² s]")
    found.set_xlabel("Searches behind each result")
    found.set_ylabel("Mean rank of the choice")
    return drawing


def _ranked(axes: Axes, table: Columns, numbers: dict[str, float]) -> None:
    order = np.argsort(table["rank"])
    rank, mean, inside = table["rank"][order], table["mean"][order], table["in_array"][order].astype(bool)
    blue, red = style.MARKS[0], style.MARKS[2]
    axes.plot(
        rank[~inside], mean[~inside], blue.marker, color=blue.colour, markerfacecolor="white", label="not in the array"
    )
    axes.plot(rank[inside], mean[inside], blue.marker, color=blue.colour, label="in the array")
    for set_name, words, lift, mark in (
        ("published", "chosen in the paper", 78.0, style.PUBLISHED_POINT | {"markersize": 14, "markeredgewidth": 1.3}),
        ("rerun", "chosen by the array here", 40.0, {"color": red.colour, "marker": red.marker, "markersize": 11}),
    ):
        wanted = [numbers.get(f"{set_name}_chosen_{knob}", np.nan) for knob in _KNOBS]
        row = np.all(
            [np.isclose(table[knob][order].astype(float), value) for knob, value in zip(_KNOBS, wanted, strict=True)],
            axis=0,
        )
        for place in np.flatnonzero(row):
            _point_at(axes, (float(rank[place]), float(mean[place])), (words, wanted), lift, mark, len(rank))
    spread = table["standard_deviation"].astype(float)
    middle = float(np.nanmedian(spread)) if np.isfinite(spread).any() else np.nan
    axes.set_title(f"All {len(mean)} combinations; single searches spread by {middle:.2g} mW² s")
    _outliers(axes, rank, mean)
    axes.legend(loc="upper left", fontsize=9, handlelength=1.0)


def _outliers(axes: Axes, rank: np.ndarray, mean: np.ndarray) -> None:
    """End the axis where the bulk does; tell what lies above it at its edge."""
    low, high = float(np.min(mean)), float(np.quantile(mean, 0.9))
    above = mean > high + 0.5 * (high - low)
    if not np.any(above):
        return
    top = low + 1.35 * (float(np.max(mean[~above])) - low)
    axes.set_ylim(low - 0.06 * (top - low), top)
    axes.plot(
        rank[above], np.full(np.count_nonzero(above), top), "^", color=style.MARKS[0].colour, markersize=7,
        markerfacecolor="white", clip_on=False,
        label=f"{np.count_nonzero(above)} beyond, up to {float(np.max(mean)):.3g}",
    )  # fmt: skip


def _point_at(
    axes: Axes,
    place: tuple[float, float],
    words: tuple[str, list[float]],
    lift: float,
    mark: dict[str, Any],
    count: int,
) -> None:
    """Mark a chosen combination and name it, on the side where there is room."""
    side = 1 if place[0] < 0.38 * count else -1
    knobs = ", ".join(f"{value:g}" for value in words[1])
    text = f"{words[0]}\nC1, C2, W = {knobs}"
    axes.plot(*place, **mark | {"zorder": 5, "markerfacecolor": "none", "markeredgecolor": mark["color"]})
    axes.annotate(
        text, place, xytext=(20 * side, lift), textcoords="offset points", ha="left" if side > 0 else "right",
        va="center", fontsize=9, color=mark["color"],
        arrowprops={"arrowstyle": "-", "color": mark["color"], "linewidth": 0.8},
    )  # fmt: skip


def _agreement(axes: Axes, table: Columns, combinations: int) -> None:
    effort = table["searches_per_run"]
    curves = {"the array's level sums": table["mean_rank"], "the array's best run": table["mean_rank_of_best_run"]}
    for (label, values), mark in zip(curves.items(), style.MARKS, strict=False):
        axes.plot(effort, values, color=mark.colour, linestyle=mark.line, marker=mark.marker, label=label)
    axes.axhline(0.5 * (combinations + 1), color=style.GREY, linestyle=":", label="a choice by chance")
    axes.axhline(1.0, color="#222222", linewidth=0.8, label="the best of all")
    axes.set_xscale("log")
    axes.set_xticks(effort, [f"{value:g}" for value in effort])
    axes.minorticks_off()
    axes.set_ylim(0.0, 0.95 * combinations)
    share, of = 100.0 * table["found_share"].astype(float), float(effort[-1]) if len(effort) else np.nan
    axes.set_title(
        f"With {of:g} searches the level sums\nchoose the best itself in {share[-1]:.0f} %" if len(share) else ""
    )
    axes.legend(loc="upper left", fontsize=9)
