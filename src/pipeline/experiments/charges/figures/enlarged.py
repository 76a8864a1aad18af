"""Current or voltage at full resolution in the windows of a charge (Figures 12 and 14)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("charge", "switched")


class Options(Record):
    """A quantity at full resolution, in the windows of the charge."""

    quantity: Literal["current", "voltage"]
    windows: tuple[int, ...] = Field(default=(), description="which windows, from 0; empty for all of them")


_COLUMNS = {"current": ("current_a", "Current [A]"), "voltage": ("voltage_v", "Voltage [V]")}

_BAND_PERIODS = 6
"""Switching periods that share a step of the band: less than a pixel."""
_SWITCHED = {
    "current": ("battery_min_a", "battery_mean_a", "battery_max_a"),
    "voltage": ("voltage_min_v", "voltage_mean_v", "voltage_max_v"),
}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the windows side by side, a strip for each mode: the modes' edges coincide, so that none hides another.

    Arguments
    ---------
    figure : the card; its options name the quantity and the windows.
    data : the charges.

    Returns
    -------
    The figure; strips of one comparison lie together under its title. Where the converters are known switch by switch,
    a light band is the range within each switching period, and the line its mean.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    strips = [(comparison, mode) for comparison in data.shown(figure.comparison) for mode in data.charged(comparison)]
    windows = _windows(data, strips, options)
    drawing = style.figure(0.9 + 1.15 * max(1, len(strips)))
    share: Literal["all", "col"] = "all" if options.quantity == "current" else "col"
    fields = drawing.subplots(max(1, len(strips)), max(1, len(windows)), sharex="col", sharey=share, squeeze=False)
    marks = style.marks(list(data.modes))
    for row, (comparison, mode) in enumerate(strips):
        is_first = row == 0 or strips[row - 1][0] != comparison
        for axes, window in zip(fields[row], windows, strict=False):
            _strip(axes, data.charge(comparison, mode, "waveform"), window, options.quantity, marks[mode])
            if "switched" in data.inputs:
                _band(axes, data.table("switched", "periods"), (comparison, mode, window), options.quantity)
            if is_first:
                axes.set_title(f"{data.comparisons[comparison]}, from {_start(data, strips, window)}")
        fields[row, 0].set_ylabel(data.modes[mode].title)
    for axes in fields[-1]:
        axes.set_xlabel("Time since the window began [ms]")
    drawing.supylabel(_COLUMNS[options.quantity][1], fontsize="medium")
    if not windows:
        for axes in fields.ravel():
            style.nothing(axes, "no window at full resolution in this run")
    return drawing


def _windows(data: ReportData, strips: list[tuple[str, str]], options: Options) -> list[int]:
    found = {int(number) for strip in strips for number in np.unique(data.charge(*strip, "waveform")["window"])}
    return sorted(found & set(options.windows) if options.windows else found)


def _start(data: ReportData, strips: list[tuple[str, str]], window: int) -> str:
    waveforms = [data.charge(*strip, "waveform") for strip in strips]
    return clock(min(float(w["time_s"][w["window"] == window][0]) for w in waveforms if np.any(w["window"] == window)))


def _strip(axes: Axes, waveform: Columns, window: int, quantity: str, mark: style.Mark) -> None:
    rows = waveform["window"] == window
    if not np.any(rows):
        style.nothing(axes, "the charge had ended")
        return
    time_s, values = waveform["time_s"][rows], waveform[_COLUMNS[quantity][0]][rows]
    if quantity == "current":
        axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.plot(1000.0 * (time_s - time_s[0]), values, color=mark.colour, linewidth=1.4)


def _band(axes: Axes, periods: Columns, place: tuple[str, str, int], quantity: str) -> None:
    comparison, mode, window = place
    rows = (periods["comparison"] == comparison) & (periods["mode"] == mode) & (periods["window"] == window)
    if not np.any(rows):
        return
    time_ms = 1000.0 * (periods["time_s"][rows] - periods["time_s"][rows][0])
    low, mean, high = (periods[name][rows] for name in _SWITCHED[quantity])
    line = axes.lines[-1]
    line.set(alpha=0.35, linewidth=0.8)
    starts = np.arange(0, len(time_ms), _BAND_PERIODS)
    band = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
    axes.fill_between(time_ms[starts], *band, color=line.get_color(), alpha=0.3, linewidth=0, step="post")
    axes.plot(time_ms, mean, color=line.get_color(), linewidth=1.0)


def clock(seconds: float) -> str:
    """Return a time of the charge as hours and minutes, with seconds where there are any."""
    whole = round(seconds)
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours} h {minutes:02d} min" + (f" {rest:02d} s" if rest else "")
