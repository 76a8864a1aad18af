"""Charging time against temperature rise: the front, the printed currents, a constant current."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("front", "staging")


class Options(Record):
    """Staged charges that matter."""

    cases: dict[str, str] = Field(min_length=1, max_length=7, description="name of a case -> what it is called here")
    published_s: float | None = Field(default=None, gt=0, description="charging time that the paper gives [s]")
    published_k: float | None = Field(default=None, gt=0, description="highest rise that the paper gives [K]")


_TITLES = {"peak": "highest rise", "final": "rise at the end"}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a field for each reading of the rise.

    Arguments
    ---------
    figure : the card; its options name the charges to be marked.
    data : the front, and the staged charges that matter.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(6.9)
    rows = drawing.subplots(2, 2, sharey="row", height_ratios=(3, 4))
    for near, fields in enumerate(rows):
        for axes, reading in zip(fields, _TITLES, strict=True):
            _field(axes, data, reading, options.cases)
            _window(axes, data, reading, near=bool(near))
            if reading == "peak" and options.published_s is not None and options.published_k is not None:
                axes.plot(options.published_s, options.published_k, label="published", **style.PUBLISHED_POINT)
        fields[0].set_ylabel("Temperature rise [K]")
    for axes, title in zip(rows[0], _TITLES.values(), strict=True):
        axes.set_title(title)
    for axes in rows.ravel():
        axes.set_xlabel("Charging time [s]")
    handles, labels = rows[0, 0].get_legend_handles_labels()
    style.above(drawing, handles, labels, size=10.0)
    return drawing


def _field(axes: Axes, data: ReportData, reading: str, cases: dict[str, str]) -> None:
    front = data.table("front", "front")
    scan = (front["method"] == "scan") & (front["rise"] == reading)
    evolved = (front["method"] == "nsga2") & (front["rise"] == reading)
    time, rise = front["time_s"], front["rise_k"]
    axes.plot(time[scan], rise[scan], color="#222222", linewidth=1.2, label="local solver, over the weights")
    axes.plot(time[evolved], rise[evolved], ".", color=style.MARKS[5].colour, markersize=5, label="NSGA-II")
    found = data.table("staging", "cases")
    marks = [style.MARKS[place] for place in (2, 0, 1, 4, 6)]
    for (name, title), mark in zip(cases.items(), marks, strict=False):
        row = found["case"] == name
        if row.any():
            axes.plot(
                found["time_s"][row],
                found[f"{reading}_k"][row],
                mark.marker,
                color=mark.colour,
                markersize=8,
                label=title,
            )
    _constant(axes, data, reading)


def _window(axes: Axes, data: ReportData, reading: str, near: bool) -> None:
    """Show all of the front, or what lies about the printed currents."""
    front, numbers = data.table("front", "front"), data.numbers("staging")
    if near:
        time, rise = numbers["printed_time_s"], numbers[f"printed_{reading}_k"]
        axes.set_xlim(0.75 * time, 1.2 * time)
        axes.set_ylim(0.65 * rise, 1.4 * rise)
        return
    axes.set_xlim(float(front["time_s"].min()) - 50.0, float(front["time_s"].max()) + 50.0)
    axes.set_ylim(0.0, 1.05 * float(front["rise_k"].max()))


def _constant(axes: Axes, data: ReportData, reading: str) -> None:
    numbers = data.numbers("staging")
    times = ("printed_time_s", f"constant_same_{reading}_s")
    rises = (f"constant_same_time_{reading}_k", f"printed_{reading}_k")
    if all(name in numbers for name in (*times, *rises)):
        points = zip((numbers[name] for name in times), (numbers[name] for name in rises), strict=True)
        time, rise = zip(*points, strict=True)
        axes.plot(
            time,
            rise,
            "D",
            color="white",
            markeredgecolor="#222222",
            markersize=9,
            label="constant current",
            zorder=1.9,
        )
