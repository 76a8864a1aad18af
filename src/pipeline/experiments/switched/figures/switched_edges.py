"""Current or voltage about the steps of the pulses, switch by switch (within Figures 12 and 14)."""

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
    """A quantity about the steps of the pulses, switch by switch."""

    quantity: Literal["current", "voltage"]
    window: int = Field(default=0, ge=0, description="which window, from 0")


_COLUMNS = {"current": ("battery_a", "Current [A]"), "voltage": ("voltage_v", "Voltage [V]")}
_PLACES = {"charge begins": 0, "charge ends": 1, "discharge begins": 1, "discharge ends": 2}
"""Kind of step -> column in which it is drawn."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a strip for each mode with pulses, a field for each kind of step.

    Arguments
    ---------
    figure : the card; its options name the quantity and the window, and it may name a comparison.
    data : the converters' samples.

    Returns
    -------
    The figure; it says so where there are no pulses in the window.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    shown = _shown(figure, data, options.window)
    strips = list(dict.fromkeys(zip(shown["comparison"], shown["mode"], strict=True))) if shown else []
    drawing = style.figure(0.9 + 1.9 * max(1, len(strips)))
    if not strips:
        axes = drawing.subplots()
        axes.set(xlabel="Time since the step [ms]", ylabel=_COLUMNS[options.quantity][1])
        style.nothing(axes, "no pulses in this window")
        return drawing
    fields = drawing.subplots(len(strips), 3, sharex=True, sharey="row", squeeze=False)
    marks = style.marks(list(data.modes))
    for row, (comparison, mode) in enumerate(strips):
        own = _rows(shown, (shown["comparison"] == comparison) & (shown["mode"] == mode))
        spare = _strip(fields[row], own, options.quantity, marks[mode])
        if row == 0:
            _tell(drawing, spare, options.quantity, [marks[name] for _, name in strips])
        title = data.modes[mode].title
        several = len({name for name, _ in strips}) > 1
        fields[row, 0].set_ylabel(f"{title}\n{data.comparisons[comparison]}" if several else title)
    for axes in fields[-1]:
        axes.set_xlabel("Time since the step [ms]")
    drawing.supylabel(_COLUMNS[options.quantity][1], fontsize="medium")
    return drawing


def _shown(figure: FigureCard, data: ReportData, window: int) -> Columns:
    if "switched" not in data.inputs:
        return {}
    found = data.table("switched", "waveform")
    wanted = (found["window"] == window) & np.isin(found["comparison"], data.shown(figure.comparison))
    return _rows(found, wanted & np.isin(found["mode"], list(data.modes)))


def _rows(columns: Columns, wanted: np.ndarray) -> Columns:
    return {name: column[wanted] for name, column in columns.items()}


def _strip(fields: np.ndarray, own: Columns, quantity: str, mark: style.Mark) -> Axes | None:
    """Draw the steps of a mode; return a field that is left over."""
    used = set()
    for kind in dict.fromkeys(own["kind"]):
        axes = fields[_PLACES[str(kind)]]
        used.add(_PLACES[str(kind)])
        _step(axes, _rows(own, own["kind"] == kind), quantity, mark)
        axes.set_title(str(kind).capitalize())
    left = sorted(set(range(3)) - used)
    for place in left:
        fields[place].set_axis_off()
    return fields[left[-1]] if left else None


def _tell(drawing: Figure, spare: Axes | None, quantity: str, marks: list[style.Mark]) -> None:
    """Put the legend into a field that is left over, or above all."""
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D

    own = tuple(Line2D([], [], color=mark.colour, linewidth=1.6) for mark in dict.fromkeys(marks))
    found: list[tuple[Any, str]] = [(own, "at the battery, switch by switch")]
    if quantity == "current":
        found.append((Line2D([], [], color=style.GREY, linewidth=1.0, alpha=0.8), "the inductor's current"))
    found.append((Line2D([], [], color=style.GREY, linewidth=0.8, linestyle=":"), "the charge asks for the step"))
    handles, labels = zip(*found, strict=True)
    look: dict[str, Any] = {"handler_map": {tuple: HandlerTuple(ndivide=None, pad=0.2)}}
    if spare is not None:
        spare.legend(handles, labels, loc="center left", fontsize=9, **look)
    else:
        style.above(drawing, handles, labels, **look)


def _step(axes: Axes, own: Columns, quantity: str, mark: style.Mark) -> None:
    time_ms = 1000.0 * own["time_s"]
    axes.axvline(0.0, color=style.GREY, linewidth=0.8, linestyle=":")
    if quantity == "current":
        axes.axhline(0.0, color=style.GREY, linewidth=0.8)
        axes.plot(time_ms, own["inductor_a"], color=style.GREY, linewidth=0.5, alpha=0.7)
    axes.plot(time_ms, own[_COLUMNS[quantity][0]], color=mark.colour, linewidth=1.0)
