"""The logistic map: where it goes over r, and how its values at r = 4 are distributed (Figure 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("chaos",)
Options = NoOptions


_FULL_CHAOS = 4.0
_ORBIT_SHOWN = 60


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the bifurcation diagram with r = 4 marked, the first values there, and their density.

    Arguments
    ---------
    figure : the card.
    data : the orbits of the map.

    Returns
    -------
    The figure.
    """
    drawing = style.figure(5.6)
    grid = drawing.add_gridspec(2, 2, height_ratios=(1.35, 1.0))
    _bifurcation(drawing.add_subplot(grid[0, :]), data)
    orbit, density = drawing.add_subplot(grid[1, 0]), drawing.add_subplot(grid[1, 1])
    values = data.table("chaos", "orbit")["value"]
    _orbit(orbit, values)
    _density(density, values)
    return drawing


def _bifurcation(axes: Axes, data: ReportData) -> None:
    table = data.table("chaos", "bifurcation")
    axes.plot(
        table["r"], table["value"], ",", color=style.MARKS[0].colour, alpha=0.35, markeredgewidth=0, rasterized=True
    )
    axes.axvline(_FULL_CHAOS, color=style.MARKS[2].colour, linewidth=1.2)
    axes.annotate(
        "r = 4", (_FULL_CHAOS, 0.5), xytext=(-4, 0), textcoords="offset points", ha="right", va="center",
        color=style.MARKS[2].colour, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5},
    )  # fmt: skip
    axes.set_xlim(float(table["r"].min()), _FULL_CHAOS + 0.01)
    axes.set_ylim(0.0, 1.0)
    axes.set_xlabel("Parameter r")
    axes.set_ylabel("Values of the map")
    axes.set_title("Where the map goes after its transient")


def _orbit(axes: Axes, values: np.ndarray) -> None:
    shown = values[:_ORBIT_SHOWN]
    axes.plot(np.arange(len(shown)), shown, color=style.MARKS[0].colour, linewidth=0.9, marker="o", markersize=2.6)
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel("Step")
    axes.set_ylabel("Value at r = 4")
    axes.set_title("The first values at r = 4")


def _density(axes: Axes, values: np.ndarray) -> None:
    bins = int(np.clip(np.sqrt(len(values)) / 2.0, 8, 40))
    axes.hist(
        values, bins=bins, range=(0.0, 1.0), density=True, color=style.MARKS[0].colour, alpha=0.3,
        label=f"{len(values)} values of the map",
    )  # fmt: skip
    x = np.sin(0.5 * np.pi * np.linspace(0.02, 0.98, 301)) ** 2
    axes.plot(x, 1.0 / (np.pi * np.sqrt(x * (1.0 - x))), color=style.MARKS[2].colour, label="arcsine law")
    axes.plot(
        [0.0, 1.0], [1.0, 1.0], color=style.PUBLISHED, linestyle=style.MARKS[1].line, label="uniform, as published"
    )
    axes.set_ylim(0.0, 5.0)
    axes.set_xlabel("Value at r = 4")
    axes.set_ylabel("Density")
    axes.set_title("How they are distributed")
    axes.legend(loc="upper center", fontsize=9)
