"""The best frequency over the two things that decide it, and where the published one would be the best."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("objective",)
Options = NoOptions


_LEVELS_HZ = (10.0, 20.0, 30.0, 50.0, 150.0, 200.0, 300.0, 500.0, 1000.0)
_MICRO = 1e6
_MARGIN = 0.06
"""A label of a contour closer to the frame than this share of it would be cut."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the best frequency as a map over switching energy and capacitance of the fastest pair.

    Arguments
    ---------
    figure : the card.
    data : the objective's map, contour and named numbers.

    Returns
    -------
    The figure, the contour of the published frequency drawn heavily.
    """
    table = data.table("objective", "map")
    drawing = style.figure(4.6)
    axes = drawing.subplots()
    axes.set_xlabel("Energy of the switches in a period [µJ]")
    axes.set_ylabel("Capacitance of the fastest RC pair [F]")
    if not len(table["optimal_frequency_hz"]):
        style.nothing(axes, "the battery has no RC pair, and its loss no optimum")
        return drawing
    energy, capacitance = np.unique(table["switching_energy_j"]), np.unique(table["capacitance_f"])
    best = table["optimal_frequency_hz"].astype(float).reshape(len(capacitance), len(energy))
    axes.set_xscale("log")
    axes.set_yscale("log")
    mesh = axes.pcolormesh(
        _MICRO * energy, capacitance, np.log10(best), cmap="cividis", shading="gouraud", rasterized=True
    )
    ticks = [hertz for hertz in (10, 20, 50, 100, 200, 500, 1000) if best.min() <= hertz <= best.max()]
    bar = drawing.colorbar(mesh, ax=axes, ticks=np.log10(ticks), pad=0.02)
    bar.ax.set_yticklabels([f"{hertz:g}" for hertz in ticks])
    bar.ax.minorticks_off()
    bar.set_label("Frequency of least loss [Hz]")
    _contours(axes, _MICRO * energy, capacitance, best, data)
    nominal = (
        _MICRO * data.numbers("objective").get("switching_energy_j", np.nan),
        float(np.sqrt(capacitance[0] * capacitance[-1])),
    )
    axes.plot(*nominal, "o", color="white", markeredgecolor="#222222", markersize=8, zorder=5)
    axes.annotate(
        "as configured",
        nominal,
        xytext=(9, 9),
        textcoords="offset points",
        zorder=5,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.2},
    )
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(False)
    axes.margins(0.0)
    return drawing


def _contours(axes: Axes, energy_uj: np.ndarray, capacitance_f: np.ndarray, best: np.ndarray, data: ReportData) -> None:
    lines = axes.contour(energy_uj, capacitance_f, best, levels=_LEVELS_HZ, colors="white", linewidths=0.8)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.2}
    for text in axes.clabel(lines, fmt="%g Hz", fontsize=8, colors="black", inline=False, zorder=4):
        text.set_bbox(box)
        place = axes.transAxes.inverted().transform(axes.transData.transform(text.get_position()))
        text.set_visible(bool(np.all((place > _MARGIN) & (place < 1.0 - _MARGIN))))
    published = data.table("objective", "contour")
    inside = (published["switching_energy_j"] * _MICRO >= energy_uj[0]) & (
        published["switching_energy_j"] * _MICRO <= energy_uj[-1]
    )
    x, y = _MICRO * published["switching_energy_j"][inside], published["capacitance_f"][inside]
    axes.plot(x, y, color="white", linewidth=5.0)
    axes.plot(x, y, color=style.PUBLISHED, linewidth=2.6)
    if len(x):
        axes.annotate(
            "90 Hz, as published", (x[4 * len(x) // 5], y[4 * len(x) // 5]), xytext=(4, 14), textcoords="offset points",
            color=style.PUBLISHED, fontsize=10, fontweight="bold", bbox=box, zorder=5,
        )  # fmt: skip
