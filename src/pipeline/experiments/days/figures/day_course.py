"""Days in the sun side by side: light, power, state of charge, temperature, and what the switches do."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.experiments.days.numbers import charged, weathers
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("weather", "day")
Options = NoOptions


_TIME, _POWER = "Local time [h]", "Power [W]"
_HOUR_S = 3600.0
_STATES = {
    "off": ("off", "#f1f1f1"),
    "mode_1": ("Mode 1", "#88aacc"),
    "mode_2": ("Mode 2", "#eecc66"),
    "ended": ("ended", "#c9c9c9"),
}
_UNUSED = "#e3e3e3"


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw each day in a column.

    Arguments
    ---------
    figure : the card.
    data : the days.

    Returns
    -------
    The figure; it says so where there are no days.
    """
    from matplotlib.ticker import MultipleLocator

    titles = weathers(data)
    if not titles:
        drawing = style.figure(3.0)
        axes = drawing.subplots()
        style.nothing(axes, "no days in this run")
        axes.set(xlabel=_TIME, ylabel=_POWER)
        return drawing
    drawing = style.figure(9.0)
    fields = drawing.subplots(
        5, len(titles), squeeze=False, sharex=True, sharey="row", height_ratios=[1.0, 1.35, 1.2, 1.2, 0.75]
    )
    for column, (name, title) in zip(fields.T, titles.items(), strict=True):
        column[0].set_title(title)
        _light(column[0], data, name)
        _powers(column[1], data, name)
        _lines(column[2], data, name, "soc", 100.0)
        _lines(column[3], data, name, "temperature_c", 1.0)
        _states(column[4], data, name)
        column[4].set_xlabel(_TIME)
        column[4].xaxis.set_major_locator(MultipleLocator(_hours_between(data, name)))
    words = ("Light [W/m²]", _POWER, "State of\ncharge [%]", "Battery [°C]")
    for row, label in zip(fields[:4, 0], words, strict=True):
        row.set_ylabel(label)
    for row in fields[:2].flat:
        row.set_ylim(bottom=0.0)
    _legend(drawing, data)
    return drawing


def _hours(found: dict[str, np.ndarray]) -> np.ndarray:
    """Return the ends of the intervals in local time [h], the start of the first before them."""
    first = found["clock_s"][0] - found["interval_s"][0]
    return np.concatenate([[first], found["clock_s"]]) / _HOUR_S


def _hours_between(data: ReportData, name: str) -> float:
    """Return a distance of ticks that suits the length of a day."""
    sky = data.table(f"weather/{name}", "weather")
    hours = float(sky["interval_s"].sum()) / _HOUR_S
    return next((step for step in (0.25, 0.5, 1.0, 2.0, 3.0, 6.0, 12.0, 24.0) if hours <= 6.0 * step), hours / 4.0)


def _light(axes: Axes, data: ReportData, name: str) -> None:
    sky = data.table(f"weather/{name}", "weather")
    axes.fill_between(
        sky["clock_s"] / _HOUR_S, sky["irradiance_w_m2"], step="post", color="#eecc66", linewidth=0, rasterized=True
    )


def _powers(axes: Axes, data: ReportData, name: str) -> None:
    marks = style.marks(list(data.modes))
    for place, mode in enumerate(charged(data, name)):
        found = data.table(f"day/{name}/{mode}", "trace")
        if place == 0:
            axes.fill_between(
                _hours(found)[1:], found["available_w"], step="pre", color=_UNUSED, linewidth=0, rasterized=True
            )
        axes.plot(_hours(found)[1:], found["charge_w"], color=marks[mode].colour, linewidth=1.1, alpha=0.9)


def _lines(axes: Axes, data: ReportData, name: str, column: str, scale: float) -> None:
    marks = style.marks(list(data.modes))
    for place, mode in enumerate(charged(data, name)):
        found = data.table(f"day/{name}/{mode}", "trace")
        hours = _hours(found)[1:]
        if column == "temperature_c" and place == 0:
            axes.plot(hours, found["ambient_c"], color=style.GREY, linestyle=":", linewidth=1.2)
        axes.plot(hours, scale * found[column], color=marks[mode].colour, linestyle=marks[mode].line, linewidth=1.5)


def _states(axes: Axes, data: ReportData, name: str) -> None:
    modes = charged(data, name)
    for place, mode in enumerate(modes):
        found = data.table(f"day/{name}/{mode}", "switching")
        end = float(data.table(f"day/{name}/{mode}", "trace")["clock_s"][-1])
        edges = np.append(found["clock_s"], end) / _HOUR_S
        colours = [_STATES[str(state)][1] for state in found["after"]]
        axes.barh(place, np.diff(edges), left=edges[:-1], height=0.8, color=colours, linewidth=0)
    axes.set_yticks(range(len(modes)), [data.modes[mode].title for mode in modes])
    axes.set_ylim(len(modes) - 0.5, -0.5)
    axes.grid(False)


def _legend(drawing: Figure, data: ReportData) -> None:
    from matplotlib.patches import Patch

    shown = {mode: mark for mode, mark in style.marks(list(data.modes)).items() if _is_shown(data, mode)}
    handles = [*style.handles({mode: data.modes[mode].title for mode in shown}, shown, markers=False)]
    handles += [Patch(color=_UNUSED, label="power the battery could have")]  # type: ignore[list-item]
    handles += [Patch(color=colour, label=words) for words, colour in _STATES.values()]  # type: ignore[misc]
    drawing.legend(handles=handles, loc="outside upper center", ncols=4, fontsize=9)


def _is_shown(data: ReportData, mode: str) -> bool:
    return any(mode in charged(data, name) for name in weathers(data))
