"""What each level of C1, C2 and W came to: in the paper's Table 2, and with the array run anew."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("tuning",)
Options = NoOptions


_SETS = {"published": "Table 2 as printed", "rerun": "The array run anew on our objective"}
_MARKS = {"published": style.Mark(style.PUBLISHED, "-", "o"), "rerun": style.MARKS[0]._replace(marker="s")}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the mean result at each level of each factor with its 95 % interval.

    Arguments
    ---------
    figure : the card.
    data : the tuning's levels and analysis of variance.

    Returns
    -------
    The figure, a row for each set of results; a full symbol is the level of least sum.
    """
    sets = [name for name in _SETS if data.holds("tuning", f"{name}_levels")]
    factors = list(dict.fromkeys(data.table("tuning", f"{sets[-1]}_levels")["factor"].tolist()))
    drawing = style.figure(0.4 + 2.5 * len(sets))
    fields = drawing.subplots(len(sets), len(factors), sharex="col", sharey="row", squeeze=False)
    for row, name in enumerate(sets):
        for column, factor in enumerate(factors):
            axes = fields[row, column]
            _levels(axes, data, name, factor, _MARKS[name])
            chance = _chance(data, name, factor)
            axes.set_title(f"{factor.upper()}: " + ("p < 0.001" if chance < 0.001 else f"p = {chance:.2f}"))
            if row == len(sets) - 1:
                axes.set_xlabel(f"{factor.upper()}")
        fields[row, 0].set_ylabel(style.label(f"{_SETS[name]}\nmean ISE", "1" if name == "published" else "mW² s"))
    return drawing


def _levels(axes: Axes, data: ReportData, name: str, factor: str, mark: style.Mark) -> None:
    table = data.table("tuning", f"{name}_levels")
    rows = table["factor"] == factor
    setting, mean, chosen = table["setting"][rows], table["mean"][rows], table["chosen"][rows].astype(bool)
    half = _half_interval(data, name, int(rows.sum()))
    axes.axhline(float(np.mean(mean)), color=style.GREY, linewidth=0.8, linestyle=":")
    axes.errorbar(setting, mean, yerr=half, color=mark.colour, linewidth=1.2, capsize=3)
    axes.plot(setting[~chosen], mean[~chosen], mark.marker, color=mark.colour, markerfacecolor="white")
    axes.plot(setting[chosen], mean[chosen], mark.marker, color=mark.colour, markersize=8, zorder=5)
    axes.set_xticks(setting, [f"{value:g}" for value in setting])
    axes.margins(x=0.12)


def _half_interval(data: ReportData, name: str, levels: int) -> float:
    """Return half the 95 % interval of a level's mean, from the error that the factors leave."""
    from scipy.special import stdtrit

    anova, runs = data.table("tuning", f"{name}_anova"), data.table("tuning", f"{name}_runs")
    error = anova["source"] == "error"
    square, freedom = float(anova["mean_square"][error][0]), float(anova["degrees_of_freedom"][error][0])
    if not freedom > 0:
        return float("nan")
    return float(stdtrit(freedom, 0.975) * np.sqrt(square * levels / len(runs["result"])))


def _chance(data: ReportData, name: str, factor: str) -> float:
    anova = data.table("tuning", f"{name}_anova")
    return float(anova["p"][anova["source"] == factor][0])
