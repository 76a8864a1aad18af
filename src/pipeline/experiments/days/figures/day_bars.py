"""Bars that split a day into parts: its energy from sun to battery, or its hours by what limits the charge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from pipeline.experiments.days.numbers import charged, weathers
from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("weather", "day")


class Options(Record):
    """Days in the sun, split into parts."""

    quantity: Literal["energy", "time"] = Field(default="energy", description="what the bars split")


_ENERGY = {
    "stored_wh": "stored",
    "battery_wh": "heat of the battery",
    "resistor_wh": "discharge resistor",
    "buck_wh": "buck converter",
    "load_wh": "load",
    "boost_wh": "boost converter",
    "curtailed_wh": "not needed",
    "tracker_wh": "not tracked",
    "panel_wh": "warm cells, low light",
}
_HOURS = {
    "current_limited_s": "at the current limit",
    "voltage_limited_s": "at the voltage limit",
    "supply_limited_s": "at the limit of the supply",
    "paused": "discharge and rest of pulses",
    "off": "off: not enough sun",
    "ended": "ended",
}
_LABELS = {"energy": "Energy over the day [Wh]", "time": "Hours of the day, added up by what limits the charge [h]"}
_HOUR_S = 3600.0
_LABELLED = 0.028
_SMALL = 0.0004


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a bar for each day and mode.

    Arguments
    ---------
    figure : the card; its options say what is split.
    data : the days.

    Returns
    -------
    The figure; it says so where there are no days.
    """
    from matplotlib.patches import Patch

    options = figure.chosen()
    assert isinstance(options, Options)
    titles = weathers(data)
    if not titles:
        drawing = style.figure(3.0)
        axes = drawing.subplots()
        style.nothing(axes, "no days in this run")
        axes.set_xlabel(_LABELS[options.quantity])
        axes.set_yticks([0.5], ["none"])
        return drawing
    modes = max(len(charged(data, name)) for name in titles)
    drawing = style.figure(1.5 + len(titles) * (0.45 + 0.36 * modes))
    fields = drawing.subplots(len(titles), 1, squeeze=False, sharex=True)[:, 0]
    words = _ENERGY if options.quantity == "energy" else _HOURS
    parts = style.parts(list(words))
    days = {name: {mode: _split(data, name, mode, options.quantity) for mode in charged(data, name)} for name in titles}
    most = max(sum(one.values()) for found in days.values() for one in found.values())
    for axes, (name, title) in zip(fields, titles.items(), strict=True):
        axes.set_title(title)
        axes.margins(x=0.08)
        found = days[name]
        for place, one in enumerate(found.values()):
            _bar(axes, place, one, parts, most)
        axes.set_yticks(range(len(found)), [data.modes[mode].title for mode in found])
        axes.set_ylim(len(found) - 0.5, -0.5)
        axes.grid(False, axis="y")
    fields[-1].set_xlabel(_LABELS[options.quantity])
    handles = [Patch(**style.filled(part), label=words[key]) for key, part in parts.items()]
    style.above(drawing, handles, handlelength=2.0)
    return drawing


def _split(data: ReportData, name: str, mode: str, quantity: str) -> dict[str, float]:
    found = data.numbers(f"day/{name}/{mode}")
    if quantity == "energy":
        return {key: found.get(key, 0.0) for key in _ENERGY}
    trace = data.table(f"day/{name}/{mode}", "trace")
    spent = {
        state: float(trace["interval_s"][trace["state"] == state].sum())
        for state in ("off", "mode_1", "mode_2", "ended")
    }
    parts = {key: found[key] for key in ("current_limited_s", "voltage_limited_s", "supply_limited_s")}
    parts["paused"] = spent["mode_1"] + spent["mode_2"] - sum(parts.values())
    parts |= {"off": spent["off"], "ended": spent["ended"]}
    return {key: max(0.0, value) / _HOUR_S for key, value in parts.items()}


def _bar(axes: Axes, place: int, found: dict[str, float], parts: dict[str, style.Part], most: float) -> None:
    """Stack the parts of a bar with their values, the sum behind them; what is too narrow is written above its part."""
    left, free_from, digits = 0.0, 0.0, 0 if most > 30.0 else 1
    for key, part in parts.items():
        value = found[key]
        middle = left + value / 2.0
        if value > 0.0:
            axes.barh(place, value, left=left, height=0.56, **style.filled(part))
        if value > _LABELLED * most:
            style.written_on(axes, middle, f"{value:.{digits}f}", part, place)
        elif value > _SMALL * most:
            beside = max(middle, free_from)
            axes.text(beside, place - 0.3, f"{value:.1f}", ha="center", va="bottom", fontsize=6.5, color=style.INK)
            free_from = beside + 0.03 * most
        left += value
    axes.text(left, place, f"  {left:.{digits}f}", va="center", fontsize=9)
