"""What the engine is off a closed form or another code, over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("validation",)


class Options(Record):
    """The lines of a check of the engine."""

    check: str = Field(min_length=1, description="name of the check")
    columns: int = Field(default=2, ge=1, le=4, description="fields in a row")
    peer: str = Field(
        default="the other code", min_length=1, description="what is compared with, where it is a program"
    )


_TITLES = {
    "maximum power over pvlib's": "Maximum power, relative to pvlib's",
    "power on a clear day over its most": "Power on a clear day, relative to its highest",
}
_NOTHING, _ROUNDING = 1e-18, 1e-13
_RESTLESS_SHARE = 0.3
"""A line that turns in more of its steps than this is noise, and drawn as points."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the magnitude of every line of a check over time, a field for each group.

    Arguments
    ---------
    figure : the card; its options name the check.
    data : the curves of the check.

    Returns
    -------
    The figure; it says so where the other code is not installed.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    table = data.table(f"validation/{options.check}", "curves")
    groups = list(dict.fromkeys(map(str, table["group"])))
    if not groups:
        drawing = style.figure(0.8)
        axes = drawing.subplots()
        axes.set_axis_off()
        style.nothing(axes, f"{options.peer} is not installed on this machine, so nothing was compared.")
        return drawing
    rows = -(-len(groups) // options.columns)
    drawing = style.figure(0.5 + 2.2 * rows)
    fields = drawing.subplots(rows, options.columns, squeeze=False)
    found = style.marks(list(dict.fromkeys(map(str, table["series"]))))
    for axes, group in zip(fields.flat, groups, strict=False):
        _field(axes, table, group, found)
    for axes in fields.flat[len(groups) :]:
        axes.set_axis_off()
    style.legend(drawing, {name: name for name in found}, found)
    return drawing


def _field(axes: Axes, table: Columns, group: str, found: dict[str, style.Mark]) -> None:
    from matplotlib.ticker import NullFormatter

    own = table["group"] == group
    most = 0.0
    for series in dict.fromkeys(map(str, table["series"][own])):
        rows = own & (table["series"] == series)
        mark, size = found[series], np.abs(table["y"][rows])
        most = max(most, float(np.max(size, initial=0.0)))
        # A difference of exactly zero has no logarithm: it is a gap.
        shown = np.where(size > _NOTHING, size, np.nan)
        look = (
            {"linestyle": "", "marker": mark.marker, "markersize": 2.2} if _is_noise(size) else {"linestyle": mark.line}
        )
        axes.plot(table["x"][rows], shown, color=mark.colour, linewidth=1.4, label=series, **look)
    up, unit = _parted(sentence(str(table["up"][own][0])))
    axes.set_yscale("log")
    axes.set_title(f"{_TITLES.get(group, sentence(group))}\nat most {_power_of_ten(most)} {unit}".rstrip())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(style.label(*_parted(sentence(str(table["across"][own][0])))))
    axes.set_ylabel(style.label(up, unit))


def _is_noise(size: np.ndarray) -> bool:
    """Tell whether a line turns so often that it shows rounding, not a course."""
    if float(np.max(size, initial=0.0)) < _ROUNDING:
        return True
    steps = np.sign(np.diff(size))
    return len(size) > 3 and float(np.mean(steps[1:] * steps[:-1] < 0)) > _RESTLESS_SHARE


def _power_of_ten(value: float) -> str:
    if value == 0.0:
        return "0"
    digits, power = f"{value:.1e}".split("e")
    return rf"${digits}\cdot10^{{{int(power)}}}$"


def _parted(label: str) -> tuple[str, str]:
    """Return the words of a label and its unit, which is empty for a ratio."""
    words, _, unit = label.removesuffix("]").partition(" [")
    return words, "" if unit == "1" else unit
