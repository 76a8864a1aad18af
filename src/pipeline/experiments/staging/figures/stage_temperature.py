"""Currents and temperature of the printed stages, with what the paper says of them (Figure 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("charge",)


class Options(Record):
    """A staged charge, and what is printed about it."""

    mode: str = Field(min_length=1, description="name of the mode")
    highest_k: float = Field(gt=0, description="highest temperature rise printed [K]")
    after_three_k: float = Field(gt=0, description="highest rise of the first three stages printed [K]")
    end_s: float = Field(gt=0, description="charging time printed [s]")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the stage currents over time above, the temperature rise below.

    Arguments
    ---------
    figure : the card; its options name the mode and what is printed about it.
    data : the charges.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(5.0)
    current, rise = drawing.subplots(2, 1, sharex=True, height_ratios=(2, 3))
    found = [name for name in data.shown(figure.comparison) if options.mode in data.charged(name)]
    if not found:
        style.nothing(rise, f"{options.mode} is not charged in this run")
        return drawing
    trace = data.charge(found[0], options.mode, "trace")
    phases = data.charge(found[0], options.mode, "phases")
    ambient = float(trace["Ambient Temperature / degC"][0])
    seconds = np.concatenate([[0.0], trace["Test Time / s"]])
    kelvin = np.concatenate([[0.0], trace["Surface Temperature / degC"] - ambient])
    mark = style.MARKS[0]
    columns = ("Test Time / s", "Current / A", "current_min_a", "current_max_a")
    current.plot(*style.stepped(*(trace[name] for name in columns)), color=mark.colour)
    rise.plot(seconds, kelvin, color=mark.colour, label="computed")
    ends = phases["end_s"]
    rise.plot(
        ends, phases["end_temperature_c"] - ambient, mark.marker, color=mark.colour, markerfacecolor="white",
        label="computed, end of each stage", linestyle="",
    )  # fmt: skip
    _names(current, phases["start_s"], ends)
    _printed(rise, options, ends)
    for axes in (current, rise):
        for end in ends[:-1]:
            axes.axvline(end, color=style.GREY, linewidth=0.7, linestyle=":")
    current.set_ylabel("Current [A]")
    current.set_ylim(0.0, 1.22 * float(np.max(trace["Current / A"])))
    rise.set_ylabel("Temperature rise [K]")
    rise.set_xlabel("Time [s]")
    rise.set_ylim(0.0, 1.25 * float(kelvin.max()))
    rise.legend(loc="lower center", fontsize=9)
    return drawing


def _names(axes: Axes, starts: np.ndarray, ends: np.ndarray) -> None:
    for number, (start, end) in enumerate(zip(starts, ends, strict=True), start=1):
        axes.text(0.5 * (start + end), 1.02, f"S{number}", transform=axes.get_xaxis_transform(), ha="center",
                  va="bottom", fontsize=9, color=style.GREY)  # fmt: skip


def _printed(axes: Axes, options: Options, ends: np.ndarray) -> None:
    """Mark what the text says was measured: the highest rise, the rise after the third stage, the end."""
    style.published(axes, options.highest_k, f"printed: at most {options.highest_k:g} K")
    style.published(axes, options.end_s, f"printed: {options.end_s:.0f} s", upright=True, at=0.12)
    axes.plot(ends[2:3], [options.after_three_k], **style.PUBLISHED_POINT)
    axes.annotate(
        f"printed: at most {options.after_three_k:g} K in S1 to S3", (ends[2], options.after_three_k), xytext=(8, -11),
        textcoords="offset points", color=style.PUBLISHED, fontsize=9,
    )  # fmt: skip
