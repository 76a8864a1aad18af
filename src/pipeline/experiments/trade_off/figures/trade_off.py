"""Charge time against peak temperature, a field for each condition."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("trade_off",)
Options = NoOptions
_STOPS = {
    "voltage_drop": ("stopped by −ΔV", style.MARKS[0]),
    "temperature_rate": ("stopped by dT/dt", style.MARKS[4]),
    "temperature": ("stopped by temperature", style.MARKS[1]),
    "timer": ("stopped by a timer", style.MARKS[5]),
}
_LABELLED = (1.0, 2.0, 4.0, 8.0)
_HOTTEST_C = 75.0
"""What gets hotter is cut off: by then the stop has not come, and the cell has vented."""
_SECONDS_PER_MINUTE = 60.0


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw constant currents as lines over their C-rates, one a stop, and the sampled modes as points.

    Arguments
    ---------
    figure : the card.
    data : the trade-off, and its settings for the titles of the conditions.

    Returns
    -------
    The figure; left and down is better.
    """
    if "trade_off" not in data.inputs:
        drawing = style.figure(3.0)
        style.nothing(drawing.subplots(), "no trade-off in this run")
        return drawing
    table = data.table("trade_off", "trade_off")
    settings: Mapping[str, Any] = data.settings.get("trade_off", {})
    conditions = list(dict.fromkeys(map(str, table["condition"])))
    rows = -(-len(conditions) // 2)
    drawing = style.figure(1.1 + 3.0 * rows)
    fields = drawing.subplots(rows, min(2, len(conditions)), squeeze=False, sharey=True)
    for axes, condition in zip(fields.flat, conditions, strict=False):
        axes.set_title(settings.get("conditions", {}).get(condition, {}).get("title", condition))
        axes.set_xscale("log")
        _constants(axes, _where(table, condition, "constant_current"))
        _modes(axes, table, condition, data)
        axes.set_xmargin(0.09)
        axes.set_ylim(float(table["peak_temperature_c"].min()) - 4.0, _HOTTEST_C)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.xaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "235" else "")
    for axes in list(fields.flat)[len(conditions) :]:
        axes.set_axis_off()
    full = 100.0 * float(settings.get("full_soc", np.nan))
    for axes in fields[-1]:
        axes.set_xlabel(f"Time until {full:g} % charged [min]")
    for row in fields:
        row[0].set_ylabel("Peak temperature [°C]")
    _legend(drawing, table, data)
    return drawing


def _where(table: Columns, condition: str, law: str) -> Columns:
    rows = (table["condition"] == condition) & (table["law"] == law) & np.isin(table["sensor"], ["", "own"])
    return {name: column[rows] for name, column in table.items()}


def _constants(axes: Axes, rows: Columns) -> None:
    for stop, (words, mark) in _STOPS.items():
        mine = (rows["stop"] == stop) & np.isfinite(rows["time_to_full_s"])
        if not np.any(mine):
            continue
        minutes, peak = rows["time_to_full_s"][mine] / _SECONDS_PER_MINUTE, rows["peak_temperature_c"][mine]
        axes.plot(minutes, peak, color=mark.colour, linestyle=mark.line, linewidth=1.5)
        if float(np.min(peak)) > 0.9 * _HOTTEST_C:
            axes.text(
                0.02, 0.96, f"{words}: {float(np.min(peak)):.0f} °C and more", transform=axes.transAxes, ha="left",
                va="top", fontsize=8.5, color=mark.colour,
            )  # fmt: skip
        if stop == "voltage_drop":
            _name_rates(axes, rows["c_rate"][mine], minutes, peak)


def _name_rates(axes: Axes, rates: NDArray[Any], minutes: NDArray[Any], peak: NDArray[Any]) -> None:
    for rate in _LABELLED:
        place = np.flatnonzero(rates == rate)
        if len(place):
            at = (float(minutes[place[0]]), float(peak[place[0]]))
            axes.plot(*at, ".", color=style.MARKS[0].colour, zorder=6)
            axes.annotate(
                f"{rate:g}C", at, xytext=(9, 5), textcoords="offset points", fontsize=8, color="#333333", zorder=7,
                bbox=style.BEHIND_WORDS,
            )  # fmt: skip


def _modes(axes: Axes, table: Columns, condition: str, data: ReportData) -> None:
    marks = style.marks(list(data.modes))
    for mode in data.modes:
        rows = _where(table, condition, mode)
        axes.plot(
            rows["time_to_full_s"] / _SECONDS_PER_MINUTE, rows["peak_temperature_c"], linestyle="",
            marker=marks[mode].marker, color=marks[mode].colour, markersize=10, markerfacecolor="none",
            markeredgewidth=1.8, zorder=5,
        )  # fmt: skip


def _legend(drawing: Figure, table: Columns, data: ReportData) -> None:
    from matplotlib.lines import Line2D

    marks = style.marks(list(data.modes))
    handles = [
        Line2D([], [], color=mark.colour, linestyle=mark.line, label=f"constant current, {words}")
        for stop, (words, mark) in _STOPS.items()
        if stop in table["stop"]
    ]
    handles += [
        Line2D(
            [],
            [],
            linestyle="",
            color=marks[mode].colour,
            marker=marks[mode].marker,
            markersize=10,
            markerfacecolor="none",
            markeredgewidth=1.8,
            label=one.title,
        )
        for mode, one in data.modes.items()
        if mode in table["law"]
    ]
    style.above(drawing, handles)
