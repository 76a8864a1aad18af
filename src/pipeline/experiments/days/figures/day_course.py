"""Days in the sun side by side: light, power, state of charge, temperature, and what the switches do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
    "off": ("off", style.REST),
    "mode_1": ("Mode 1", style.PARTS[1]),
    "mode_2": ("Mode 2", style.PARTS[4]),
    "ended": ("ended", style.PARTS[7]),
}
_LIGHT, _UNUSED = "#e8c34a", "#d9d9d9"


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
    drawing = style.figure(9.4)
    fields = drawing.subplots(
        6, len(titles), squeeze=False, sharex=True, sharey="row", height_ratios=[0.8, 1.35, 1.2, 1.0, 1.2, 0.75]
    )
    for column, (name, title) in zip(fields.T, titles.items(), strict=True):
        column[0].set_title(title)
        _light(column[0], data, name)
        _powers(column[1], data, name)
        _lines(column[2], data, name, "soc", 100.0)
        _behind(column[3], data, name)
        _lines(column[4], data, name, "temperature_c", 1.0)
        _states(column[5], data, name)
        column[5].set_xlabel(_TIME)
        column[5].xaxis.set_major_locator(MultipleLocator(_hours_between(data, name)))
    words = ("Light [W/m²]", _POWER, "State of\ncharge [%]", f"SOC less that\nof {_first(data)} [%]", "Battery [°C]")
    for row, label in zip(fields[:5, 0], words, strict=True):
        row.set_ylabel(label)
    for row in fields[:2].flat:
        row.set_ylim(bottom=0.0)
    drawing.align_ylabels(fields[:5, 0])
    _legend(drawing, data)
    return drawing


def _first(data: ReportData) -> str:
    """Return the title of the mode that the others are compared with."""
    return next((data.modes[mode].title for name in weathers(data) for mode in charged(data, name)), "the first")


def _behind(axes: Axes, data: ReportData, name: str) -> None:
    """Draw what the state of charge of each mode differs by from the first's: the curves themselves lie close."""
    marks, modes = style.marks(list(data.modes)), charged(data, name)
    first = data.table(f"day/{name}/{modes[0]}", "trace")
    axes.axhline(0.0, color=marks[modes[0]].colour, linewidth=1.2)
    for later, mode in zip(range(len(modes) - 2, -1, -1), modes[1:], strict=True):
        found = data.table(f"day/{name}/{mode}", "trace")
        less = 100.0 * (found["soc"] - np.interp(found["clock_s"], first["clock_s"], first["soc"]))
        axes.plot(
            _hours(found)[1:], less, color=marks[mode].colour, linestyle=marks[mode].line, linewidth=1.2 + 0.5 * later
        )


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
        sky["clock_s"] / _HOUR_S, sky["irradiance_w_m2"], step="post", color=_LIGHT, linewidth=0, rasterized=True
    )


def _powers(axes: Axes, data: ReportData, name: str) -> None:
    marks = style.marks(list(data.modes))
    for place, mode in enumerate(charged(data, name)):
        found = data.table(f"day/{name}/{mode}", "trace")
        if place == 0:
            axes.fill_between(
                _hours(found)[1:], found["available_w"], step="pre", color=_UNUSED, linewidth=0, rasterized=True
            )
        later = len(charged(data, name)) - 1 - place
        axes.plot(
            _hours(found)[1:], found["charge_w"], color=marks[mode].colour, linestyle=marks[mode].line,
            linewidth=0.9 + 0.6 * later,
        )  # fmt: skip


def _lines(axes: Axes, data: ReportData, name: str, column: str, scale: float) -> None:
    marks = style.marks(list(data.modes))
    for place, mode in enumerate(charged(data, name)):
        found = data.table(f"day/{name}/{mode}", "trace")
        hours = _hours(found)[1:]
        if column == "temperature_c" and place == 0:
            axes.plot(hours, found["ambient_c"], color=style.GREY, linestyle=":", linewidth=1.4)
        later = len(charged(data, name)) - 1 - place
        axes.plot(
            hours, scale * found[column], color=marks[mode].colour, linestyle=marks[mode].line,
            linewidth=1.2 + 0.6 * later,
        )  # fmt: skip


def _states(axes: Axes, data: ReportData, name: str) -> None:
    modes = charged(data, name)
    for place, mode in enumerate(modes):
        found = data.table(f"day/{name}/{mode}", "switching")
        end = float(data.table(f"day/{name}/{mode}", "trace")["clock_s"][-1])
        edges = np.append(found["clock_s"], end) / _HOUR_S
        for start, end_h, state in zip(edges[:-1], edges[1:], found["after"], strict=True):
            look = style.filled(_STATES[str(state)][1]) | {"linewidth": 0.0}
            axes.barh(place, end_h - start, left=start, height=0.8, **look)
    axes.set_yticks(range(len(modes)), [data.modes[mode].title for mode in modes])
    axes.set_ylim(len(modes) - 0.5, -0.5)
    axes.grid(False)


def _legend(drawing: Figure, data: ReportData) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    shown = {mode: mark for mode, mark in style.marks(list(data.modes)).items() if _is_shown(data, mode)}
    titles = {mode: data.modes[mode].title for mode in shown}
    handles: list[Any] = [*style.handles(titles, shown, markers=False)]
    handles += [
        Line2D([], [], color=style.GREY, linestyle=":", linewidth=1.4, label="air"),
        Patch(facecolor=_LIGHT, label="light"),
        Patch(facecolor=_UNUSED, label="power the battery could have"),
    ]
    handles += [Patch(**style.filled(part), label=words) for words, part in _STATES.values()]
    style.above(drawing, handles)


def _is_shown(data: ReportData, mode: str) -> bool:
    return any(mode in charged(data, name) for name in weathers(data))
