"""A charge of a nickel battery: voltage, temperature and its rate, with what would stop it (Figures 1, 7, 8, 9)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("charge", "trade_off")


class Options(Record):
    """A charge of a nickel battery, its signs of full marked."""

    mode: str = Field(min_length=1, description="name of the mode")
    show: tuple[Literal["current", "voltage", "temperature", "rate", "soc"], ...] = Field(
        default=("voltage", "temperature", "rate"), min_length=1, description="quantities, one field each"
    )
    c_rate: float | None = Field(default=None, gt=0, description="constant current whose stops are marked [C-rate]")
    valid_to_c: float | None = Field(default=None, description="temperature above which no cell is described [degC]")
    held_above_k_min: float | None = Field(
        default=None, gt=0, description="rate above which the network's input is held [K/min]"
    )
    published_stop_s: float | None = Field(default=None, gt=0, description="when the paper would stop it [s]")


_SIGNS = {
    "temperature_rate": "dT/dt",
    "voltage_drop": "−ΔV",
    "temperature": "temperature",
    "timer": "timer",
}
_SECONDS_PER_MINUTE = 60.0


class Row(NamedTuple):
    """How a quantity is labelled and coloured."""

    label: str
    colour: str


_FIELDS = {
    "current": Row("Current [A]", style.MARKS[3].colour),
    "voltage": Row("Voltage [V]", style.MARKS[0].colour),
    "temperature": Row("Temperature [°C]", style.MARKS[2].colour),
    "rate": Row("dT/dt [K/min]", style.MARKS[4].colour),
    "soc": Row("State of charge [%]", style.MARKS[1].colour),
}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a charge over time, a field for each quantity.

    Arguments
    ---------
    figure : the card; its options name the mode, and the constant current whose stops are marked.
    data : the charge, and the trade-off which knows when each stop acts.

    Returns
    -------
    The figure; it says so where the mode was not charged.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    comparisons = [name for name in data.shown(figure.comparison) if options.mode in data.charged(name)]
    drawing = style.figure(0.9 + 1.75 * len(options.show))
    fields = drawing.subplots(len(options.show), 1, sharex=True, squeeze=False)[:, 0]
    if not comparisons:
        style.nothing(fields[0], f"no charge by {options.mode} in this run")
        return drawing
    trace = data.charge(comparisons[0], options.mode, "trace")
    for axes, name in zip(fields, options.show, strict=True):
        time, values = _series(trace, name)
        axes.plot(time, values, color=_FIELDS[name].colour)
        axes.set_ylabel(_FIELDS[name].label)
        if name == "temperature":
            _ambient(axes, trace)
        if name == "voltage":
            _peak(axes, time, values)
    fields[-1].set_xlim(0.0, float(trace["Test Time / s"][-1]) * 1.01)
    _shade(fields, options, trace)
    is_marked = _mark(fields, options, data)
    fields[0].set_title(
        f"{data.modes[options.mode].title}, {data.comparisons[comparisons[0]]}", pad=28 if is_marked else 7
    )
    fields[-1].set_xlabel("Time [s]")
    drawing.align_ylabels()
    return drawing


def _series(trace: Columns, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times and values; means over an interval and its rate stand in its middle."""
    time = trace["Test Time / s"]
    before = np.concatenate([[0.0], time[:-1]])
    temperature = trace["Surface Temperature / degC"]
    if name == "temperature":
        return time, temperature
    if name == "soc":
        return time, 100.0 * trace["soc"]
    if name == "rate":
        rate = _SECONDS_PER_MINUTE * np.diff(temperature) / np.diff(time)
        return (time[1:] + time[:-1]) / 2.0, rate
    column = {"current": "Current / A", "voltage": "Voltage / V"}[name]
    return (time + before) / 2.0, trace[column]


def _shade(fields: NDArray[np.object_], options: Options, trace: Columns) -> None:
    """Shade where the charge is outside what the cell is described for, or its rate beyond the network's input."""
    for name, limit, words in (
        ("temperature", options.valid_to_c, "outside the\ncell's validity"),
        ("rate", options.held_above_k_min, "network's input held at {limit:g} K/min:\n{share:.0f} % of the charge"),
    ):
        if limit is None:
            continue
        time, values = _series(trace, name)
        beyond = values > limit
        said = words.format(limit=limit, share=100.0 * float(np.mean(beyond)))
        telling = options.show.index(name) if name == "rate" and name in options.show else 0
        for place, axes in enumerate(fields):
            is_told = place == telling
            style.shaded(axes, time, beyond, said if is_told else "", 0.75 if name == "rate" else 0.2)
            if name in options.show and place == options.show.index(name):
                axes.axhline(limit, color=style.INK, linewidth=0.9, linestyle=(0, (4, 2)))


def _ambient(axes: Axes, trace: Columns) -> None:
    axes.axhline(float(trace["Ambient Temperature / degC"][0]), color=style.GREY, linewidth=1.0, linestyle=":")


def _peak(axes: Axes, time: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    top = int(np.argmax(values))
    if 0 < top < len(values) - 1:
        axes.plot(time[top : top + 1], values[top : top + 1], "o", color=_FIELDS["voltage"].colour)
        axes.annotate(
            f"{values[top]:.2f} V at {time[top]:.0f} s", (float(time[top]), float(values[top])), xytext=(-8, -4),
            textcoords="offset points", ha="right", va="top", fontsize=9, color="#333333",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0}, zorder=6,
        )  # fmt: skip


def _mark(fields: NDArray[np.object_], options: Options, data: ReportData) -> bool:
    """Mark when each stop alone would end the charge, and when the paper would; tell whether anything is marked."""
    moments: dict[str, float] = {}
    if options.c_rate is not None and "trade_off" in data.inputs:
        table = data.table("trade_off", "trade_off")
        first = str(table["condition"][0])
        for stop, words in _SIGNS.items():
            rows = (table["stop"] == stop) & (table["condition"] == first) & (table["c_rate"] == options.c_rate)
            if np.any(rows):
                moments[words] = float(table["end_time_s"][rows][0])
    elif "trade_off" in data.inputs:
        moments |= _of_a_mode(data.table("trade_off", "trade_off"), options.mode, data.settings)
    if options.published_stop_s is not None:
        moments["paper"] = options.published_stop_s
    span = float(fields[0].get_xlim()[1])
    found = sorted(moments.items(), key=lambda item: item[1])
    places = style.spread([when for _, when in found], 0.085 * span)
    places = [place - max(0.0, places[-1] - 0.985 * span) for place in places]
    for (words, when), place in zip(found, places, strict=True):
        ours = words != "paper"
        colour = style.INK if ours else style.PUBLISHED
        for axes in fields:
            axes.axvline(
                when, color=style.GREY if ours else colour, linewidth=1.1, linestyle=":" if ours else (0, (4, 1.5))
            )
        fields[0].annotate(
            f"{words}\n{when:.0f} s", (when, 1.0), xycoords=("data", "axes fraction"), xytext=(place, 1.07),
            textcoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8, color=colour,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": "#bbbbbb", "linewidth": 0.7, "relpos": (0.5, 0.0), "shrinkA": 0.0},
        )  # fmt: skip
    return bool(found)


def _of_a_mode(table: Columns, mode: str, settings: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    """Return when a mode that commands its own current has charged the battery, and when the charge ends."""
    rows = (table["law"] == mode) & (table["condition"] == table["condition"][0]) & (table["sensor"] == "own")
    if not np.any(rows):
        return {}
    full = settings.get("trade_off", {}).get("full_soc")
    found = {f"{100 * full:g} % charged" if full else "charged": float(table["time_to_full_s"][rows][0])}
    return {words: when for words, when in found.items() if np.isfinite(when)}
