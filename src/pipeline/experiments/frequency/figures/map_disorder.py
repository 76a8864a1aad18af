"""How disordered the logistic map is over r, by two measures that do not agree (Figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("chaos",)
Options = NoOptions


Array = NDArray[np.float64]
_NEAR_FOUR = 3.92
_LOWEST_DIFFERENCE = -0.15
_LOWEST_EXPONENT = -1.0


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw Lyapunov exponent and binned Shannon entropy over r, and close to r = 4 against their values there.

    Arguments
    ---------
    figure : the card.
    data : the disorder of the map.

    Returns
    -------
    The figure; a symbol marks each curve's maximum.
    """
    table = data.table("chaos", "disorder")
    drawing = style.figure(5.6)
    fields = drawing.subplots(2, 2, sharex="col", width_ratios=(1.4, 1.0))
    for row, curves in enumerate((_lyapunov(table), _entropy(table))):
        for place, (label, (r, values)) in enumerate(curves.items()):
            _whole(fields[row, 0], r, values, place, label)
            _near(fields[row, 1], r, values, place)
        fields[row, 1].axhline(0.0, color=style.GREY, linewidth=0.8)
        fields[row, 1].set_ylim(_LOWEST_DIFFERENCE, 0.14)
        fields[row, 1].set_ylabel("Difference from r = 4 [nat]")
        most = dict.fromkeys(f"{r[np.argmax(values)]:.4g}" for r, values in curves.values())
        fields[row, 1].set_title("Close to r = 4: largest at " + ", ".join(most))
    fields[0, 0].axhline(0.0, color=style.GREY, linewidth=0.8)
    fields[0, 0].set_ylim(_LOWEST_EXPONENT, 0.85)
    fields[0, 0].set_title(f"Lyapunov exponent; its dips reach below {_LOWEST_EXPONENT:g}")
    fields[1, 0].set_title("Shannon entropy of the visits to equal bins")
    fields[0, 0].set_ylabel("Exponent [nat per step]")
    fields[1, 0].set_ylabel("Entropy [nat]")
    fields[1, 0].legend(loc="upper left", fontsize=9)
    for axes, low in zip(fields[1], (float(table["r"].min()), _NEAR_FOUR), strict=True):
        axes.set_xlabel("Parameter r")
        axes.set_xlim(low, 4.0 + 0.02 * (4.0 - low))
    return drawing


def _lyapunov(table: Columns) -> dict[str, tuple[Array, Array]]:
    rows = table["bins"] == table["bins"][0]
    return {"": (table["r"][rows], table["lyapunov_nats"][rows])}


def _entropy(table: Columns) -> dict[str, tuple[Array, Array]]:
    found = {}
    for bins in np.unique(table["bins"]):
        rows = table["bins"] == bins
        found[f"{bins} bins"] = (table["r"][rows], table["entropy_nats"][rows])
    return found


def _whole(axes: Axes, r: Array, values: Array, place: int, label: str) -> None:
    mark, most = style.MARKS[place], int(np.argmax(values))
    axes.plot(r, values, color=mark.colour, linestyle=mark.line, linewidth=1.6 - 0.3 * place, label=label)
    axes.plot(r[most], values[most], mark.marker, color=mark.colour, markersize=7, markeredgecolor="white")


def _near(axes: Axes, r: Array, values: Array, place: int) -> None:
    mark, most, shown = style.MARKS[place], int(np.argmax(values)), r >= _NEAR_FOUR
    less = values - values[-1]
    axes.plot(r[shown], less[shown], color=mark.colour, linestyle=mark.line, linewidth=1.2)
    if shown[most]:
        axes.plot(r[most], less[most], mark.marker, color=mark.colour, markersize=8, markeredgecolor="white", zorder=5)
