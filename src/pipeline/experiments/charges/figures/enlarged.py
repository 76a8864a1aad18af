"""Current or voltage at full resolution in the windows of a charge (Figures 12 and 14)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

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

_LEVEL_SHARE = 1e-3
"""A charge that moves less than this share of its largest value within a window has no pulses."""
_BAND_PERIODS = 6
"""Switching periods that share a step of the band: less than a pixel."""
_SWITCHED = {
    "current": ("battery_min_a", "battery_mean_a", "battery_max_a"),
    "voltage": ("voltage_min_v", "voltage_mean_v", "voltage_max_v"),
}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the windows side by side, a strip for each mode with pulses: their edges coincide, and none hides another.

    Arguments
    ---------
    figure : the card; its options name the quantity and the windows.
    data : the charges.

    Returns
    -------
    The figure; strips of one comparison lie together under its title, the modes that are level in the strips of the
    others. Where the converters are known switch by switch, a light band is the range within each switching period, a
    line its mean, and a broken line the charge that they follow.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    every = [(comparison, mode) for comparison in data.shown(figure.comparison) for mode in data.charged(comparison)]
    windows = _windows(data, every, options)
    level = {strip for strip in every if _is_level(data.charge(*strip, "waveform"), options.quantity)}
    strips = [strip for strip in every if strip not in level] or every
    drawing = style.figure(1.2 + 1.35 * max(1, len(strips)))
    share: Literal["all", "col"] = "all" if options.quantity == "current" else "col"
    fields = drawing.subplots(max(1, len(strips)), max(1, len(windows)), sharex="col", sharey=share, squeeze=False)
    marks = style.marks(list(data.modes))
    for row, (comparison, mode) in enumerate(strips):
        beside = [one for one in level - set(strips) if one[0] == comparison]
        is_first = row == 0 or strips[row - 1][0] != comparison
        for axes, window in zip(fields[row], windows, strict=False):
            for other in sorted(beside):
                _strip(axes, data, other, window, options.quantity, marks[other[1]])
            _strip(axes, data, (comparison, mode), window, options.quantity, marks[mode])
            if is_first:
                axes.set_title(f"{data.comparisons[comparison]}, from {_start(data, every, window)}")
        fields[row, 0].set_ylabel(data.modes[mode].title)
    for axes in fields[-1]:
        axes.set_xlabel("Time since the window began [ms]")
    drawing.supylabel(_COLUMNS[options.quantity][1], fontsize="medium")
    if not windows:
        for axes in fields.ravel():
            style.nothing(axes, "no window at full resolution in this run")
        return drawing
    for axes in fields.ravel():
        axes.locator_params(axis="y", nbins=4)
    _tell(drawing, data, [mode for _, mode in every], "switched" in data.inputs)
    return drawing


def _is_level(waveform: Columns, quantity: str) -> bool:
    """Tell whether a charge has no pulses in its windows."""
    values = waveform[_COLUMNS[quantity][0]]
    windows = [values[waveform["window"] == window] for window in np.unique(waveform["window"])]
    span = max((float(np.ptp(one)) for one in windows), default=0.0)
    return bool(windows) and span < _LEVEL_SHARE * max(1e-12, float(np.max(np.abs(values))))


def _tell(drawing: Figure, data: ReportData, modes: list[str], is_switched: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks = style.marks(list(data.modes))
    shown = {mode: marks[mode] for mode in data.modes if mode in modes}
    handles: list[Any] = [
        Line2D([], [], color=mark.colour, linewidth=1.8, label=data.modes[mode].title) for mode, mark in shown.items()
    ]
    if is_switched:
        handles += [
            Patch(facecolor=style.GREY, alpha=0.35, label="range within a switching period"),
            Line2D([], [], **_FOLLOWED, label="the charge that is followed"),
        ]
    style.above(drawing, handles, handlelength=2.0)


def _windows(data: ReportData, strips: list[tuple[str, str]], options: Options) -> list[int]:
    found = {int(number) for strip in strips for number in np.unique(data.charge(*strip, "waveform")["window"])}
    return sorted(found & set(options.windows) if options.windows else found)


def _start(data: ReportData, strips: list[tuple[str, str]], window: int) -> str:
    waveforms = [data.charge(*strip, "waveform") for strip in strips]
    return clock(min(float(w["time_s"][w["window"] == window][0]) for w in waveforms if np.any(w["window"] == window)))


def _strip(axes: Axes, data: ReportData, strip: tuple[str, str], window: int, quantity: str, mark: style.Mark) -> None:
    waveform = data.charge(*strip, "waveform")
    rows = waveform["window"] == window
    if not np.any(rows):
        if not axes.texts:
            style.nothing(axes, "the charge had ended")
        return
    if quantity == "current":
        axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    time_ms = 1000.0 * (waveform["time_s"][rows] - waveform["time_s"][rows][0])
    values = waveform[_COLUMNS[quantity][0]][rows]
    if "switched" in data.inputs and _band(axes, data.table("switched", "periods"), (*strip, window), quantity, mark):
        axes.plot(time_ms, values, **_FOLLOWED)
    else:
        axes.plot(time_ms, values, color=mark.colour, linewidth=1.4)


_FOLLOWED: dict[str, Any] = {"color": "#000000", "linewidth": 0.7, "linestyle": (0, (2, 3)), "zorder": 3}


def _band(axes: Axes, periods: Columns, place: tuple[str, str, int], quantity: str, mark: style.Mark) -> bool:
    """Draw range and mean of each switching period; tell whether there are any."""
    comparison, mode, window = place
    rows = (periods["comparison"] == comparison) & (periods["mode"] == mode) & (periods["window"] == window)
    if not np.any(rows):
        return False
    time_ms = 1000.0 * (periods["time_s"][rows] - periods["time_s"][rows][0])
    low, mean, high = (periods[name][rows] for name in _SWITCHED[quantity])
    starts = np.arange(0, len(time_ms), _BAND_PERIODS)
    band = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
    axes.fill_between(time_ms[starts], *band, color=mark.colour, alpha=0.35, linewidth=0, step="post")
    shared = np.diff(np.append(starts, len(time_ms)))
    axes.step(time_ms[starts], np.add.reduceat(mean, starts) / shared, where="post", color=mark.colour, linewidth=1.8)
    return True


def clock(seconds: float) -> str:
    """Return a time of the charge as hours and minutes, with seconds where there are any."""
    whole = round(seconds)
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours} h {minutes:02d} min" + (f" {rest:02d} s" if rest else "")
