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


_ENERGY = (
    ("stored_wh", "stored", "#004488"),
    ("battery_wh", "heat of the battery", "#6699cc"),
    ("resistor_wh", "discharge resistor", "#bb3355"),
    ("buck_wh", "buck converter", "#ee99aa"),
    ("load_wh", "load", "#228833"),
    ("boost_wh", "boost converter", "#ccbbdd"),
    ("curtailed_wh", "no use for it", "#dddddd"),
    ("tracker_wh", "not tracked", "#999999"),
    ("panel_wh", "panel warmer, light dimmer", "#eecc66"),
)
_HOURS = (
    ("current_limited_s", "at the current limit", "#004488"),
    ("voltage_limited_s", "at the voltage limit", "#6699cc"),
    ("supply_limited_s", "at the limit of the supply", "#eecc66"),
    ("paused", "discharge and rest of pulses", "#ee99aa"),
    ("off", "off: not enough sun", "#999999"),
    ("ended", "ended", "#dddddd"),
)
_LABELS = {"energy": "Energy [Wh]", "time": "Time [h]"}
_HOUR_S = 3600.0
_LABELLED = 0.035


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
    drawing = style.figure(1.5 + len(titles) * (0.45 + 0.3 * modes))
    fields = drawing.subplots(len(titles), 1, squeeze=False, sharex=True)[:, 0]
    parts = _ENERGY if options.quantity == "energy" else _HOURS
    for axes, (name, title) in zip(fields, titles.items(), strict=True):
        axes.set_title(title)
        found = {mode: _split(data, name, mode, options.quantity) for mode in charged(data, name)}
        most = max(sum(one.values()) for one in found.values())
        for place, one in enumerate(found.values()):
            _bar(axes, place, one, parts, most)
        axes.set_yticks(range(len(found)), [data.modes[mode].title for mode in found])
        axes.set_ylim(len(found) - 0.5, -0.5)
        axes.grid(False, axis="y")
    fields[-1].set_xlabel(_LABELS[options.quantity])
    handles = [Patch(color=colour, label=words) for _, words, colour in parts]
    drawing.legend(handles=handles, loc="outside upper center", ncols=3, fontsize=9, handlelength=1.4)
    return drawing


def _split(data: ReportData, name: str, mode: str, quantity: str) -> dict[str, float]:
    found = data.numbers(f"day/{name}/{mode}")
    if quantity == "energy":
        return {key: found.get(key, 0.0) for key, *_ in _ENERGY}
    trace = data.table(f"day/{name}/{mode}", "trace")
    spent = {
        state: float(trace["interval_s"][trace["state"] == state].sum())
        for state in ("off", "mode_1", "mode_2", "ended")
    }
    parts = {key: found[key] for key in ("current_limited_s", "voltage_limited_s", "supply_limited_s")}
    parts["paused"] = spent["mode_1"] + spent["mode_2"] - sum(parts.values())
    parts |= {"off": spent["off"], "ended": spent["ended"]}
    return {key: max(0.0, value) / _HOUR_S for key, value in parts.items()}


def _bar(axes: Axes, place: int, found: dict[str, float], parts: tuple[tuple[str, str, str], ...], most: float) -> None:
    left = 0.0
    for key, _, colour in parts:
        value = found[key]
        axes.barh(place, value, left=left, height=0.74, color=colour, edgecolor="white", linewidth=0.6)
        if value > _LABELLED * most:
            ink = "#ffffff" if colour in ("#004488", "#228833", "#bb3355") else "#000000"
            text = f"{value:.0f}" if most > 30.0 else f"{value:.1f}"
            axes.text(left + value / 2.0, place, text, ha="center", va="center", fontsize=8, color=ink)
        left += value
