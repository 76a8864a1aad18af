"""Current and voltage of one charge over time (Figure 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("charge",)


class Options(Record):
    """One charge."""

    mode: str = Field(min_length=1, description="name of the mode")
    published_soc: float | None = Field(
        default=None, gt=0, lt=1, description="SOC at which the current falls in the paper"
    )


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw current above and voltage below, with the time from which the voltage is held.

    Arguments
    ---------
    figure : the card; its options name the mode.
    data : the charges.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(4.4)
    current, voltage = drawing.subplots(2, 1, sharex=True)
    found = [name for name in data.shown(figure.comparison) if options.mode in data.charged(name)]
    if not found:
        style.nothing(current, f"{options.mode} is not charged in this run")
        return drawing
    trace = data.charge(found[0], options.mode, "trace")
    minutes = trace["Test Time / s"] / 60.0
    middle = (minutes + np.concatenate([[0.0], minutes[:-1]])) / 2.0
    for axes, column, mark in (
        (current, "Current / A", style.MARKS[0]),
        (voltage, "Voltage / V", style.MARKS[2]),
    ):
        axes.plot(middle, trace[column], color=mark.colour)
        axes.set_ylabel(column.replace(" / ", " [") + "]")
    held = np.flatnonzero(trace["voltage_limited_share"] > 0.0)
    if len(held):
        start = float(middle[held[0]])
        soc = 100.0 * float(trace["soc"][held[0]])
        for axes in (current, voltage):
            axes.axvline(start, color=style.GREY, linewidth=1.0, linestyle=":")
        voltage.annotate(
            f"voltage held\nfrom {soc:.3g} % SOC,\nfor {_lasting(trace, int(held[0])):.0f} s ", (start, 0.24),
            xycoords=("data", "axes fraction"), ha="right", va="center", color=style.GREY,
            bbox=style.BEHIND_WORDS,
        )  # fmt: skip
    if options.published_soc is not None and float(trace["soc"][-1]) > options.published_soc:
        when = float(np.interp(options.published_soc, trace["soc"], minutes))
        words = f"published: the current falls from {100 * options.published_soc:g} % SOC on"
        for axes, said in ((current, ""), (voltage, words)):
            style.published(axes, when, said, upright=True, at=0.85)
    current.set_ylim(0.0, 1.12 * float(np.max(trace["Current / A"])))
    current.set_title(data.modes[options.mode].title)
    voltage.set_xlabel("Time [min]")
    return drawing


def _lasting(trace: Columns, first: int) -> float:
    """Return how long the charge lasts from a row on [s]."""
    time = trace["Test Time / s"]
    return float(time[-1] - (time[first - 1] if first else 0.0))
