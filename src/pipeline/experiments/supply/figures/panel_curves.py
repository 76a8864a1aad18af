"""The panel's current and power over voltage, for several irradiances and temperatures."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("panel",)


class Options(Record):
    """The curves, beside what a data sheet gives at standard conditions."""

    published_a: dict[str, float] = Field(default_factory=dict, description="voltage [V] -> current given there [A]")


_REFERENCE = {"irradiance_w_m2": 1000.0, "cell_temperature_c": 25.0}
_UNITS = {"irradiance_w_m2": "W/m²", "cell_temperature_c": "°C"}
_MAPS = {"irradiance_w_m2": "viridis", "cell_temperature_c": "plasma"}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw I-V and P-V curves over irradiance and over temperature, the maximum power marked.

    Arguments
    ---------
    figure : the card.
    data : the panel's curves and points.

    Returns
    -------
    The figure: irradiance on the left, temperature on the right; current above, power below.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(6.4)
    fields = drawing.subplots(2, 2, sharex=True, sharey="row")
    curves, points = data.table("panel", "curves"), data.table("panel", "points")
    for column, (varied, kept) in enumerate(
        [("irradiance_w_m2", "cell_temperature_c"), ("cell_temperature_c", "irradiance_w_m2")]
    ):
        at = _nearest(points[kept], _REFERENCE[kept])
        fields[0, column].set_title(f"at {at:g} {_UNITS[kept]}")
        _family(fields[0, column], curves, points, varied, kept, at, "current_a", "max_power_current_a")
        _family(fields[1, column], curves, points, varied, kept, at, "power_w", "max_power_w")
        fields[1, column].set_xlabel("Panel voltage [V]")
    fields[0, 0].set_ylabel("Panel current [A]")
    fields[1, 0].set_ylabel("Panel power [W]")
    given = {float(voltage): current for voltage, current in options.published_a.items()}
    for column in range(2 if given else 0):
        for axes, values in zip(fields[:, column], (given, {v: v * a for v, a in given.items()}), strict=True):
            label = "data sheet" if axes is fields[1, 0] else ""
            axes.plot(list(values), list(values.values()), label=label, clip_on=False, **_GIVEN)
    if given:
        fields[1, 0].legend(loc="upper left", handlelength=3.0, fontsize=9)
    for axes in fields.ravel():
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
    return drawing


_GIVEN = style.PUBLISHED_POINT | {"markersize": 14, "markerfacecolor": "none", "markeredgecolor": style.PUBLISHED}


def _nearest(values: np.ndarray, wanted: float) -> float:
    return float(values[np.argmin(np.abs(values - wanted))])


def _family(
    axes: Axes, curves: Columns, points: Columns, varied: str, kept: str, at: float, quantity: str, peak: str
) -> None:
    import matplotlib

    values = np.unique(points[varied][points[kept] == at])
    shades = matplotlib.colormaps[_MAPS[varied]](np.linspace(0.0, 0.72, len(values)))
    for value, shade, mark in zip(values, shades, cycle(style.MARKS), strict=False):
        rows = (curves[kept] == at) & (curves[varied] == value)
        axes.plot(
            curves["voltage_v"][rows],
            curves[quantity][rows],
            color=shade,
            linestyle=mark.line,
            label=f"{value:g} {_UNITS[varied]}",
        )
        point = (points[kept] == at) & (points[varied] == value)
        axes.plot(points["max_power_voltage_v"][point], points[peak][point], "o", color=shade, markeredgecolor="white")
    if quantity == "power_w":
        axes.legend(loc="upper left", reverse=varied == "irradiance_w_m2", handlelength=3.0, fontsize=9)
