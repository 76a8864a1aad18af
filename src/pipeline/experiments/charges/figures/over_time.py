"""A quantity over the whole charge, the modes together, a field for each comparison (Figures 11, 13, 15, 16)."""

from __future__ import annotations

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


READS = ("charge",)


class Options(Record):
    """A quantity over the whole charge."""

    quantity: Literal["current", "voltage", "soc", "temperature"]
    time_in: Literal["h", "min", "s"] = Field(default="h", description="unit of the axis of time")


_MOST_ROWS_OF_A_BAND = 600


_SECONDS = {"h": 3600.0, "min": 60.0, "s": 1.0}


class Quantity(NamedTuple):
    """Where a quantity stands in the trace, and how its axis is labelled."""

    column: str
    label: str
    factor: float = 1.0
    band: tuple[str, str] | None = None
    is_mean: bool = False


QUANTITIES = {
    "current": Quantity("Current / A", "Current [A]", band=("current_min_a", "current_max_a"), is_mean=True),
    "voltage": Quantity("Voltage / V", "Voltage [V]", band=("voltage_min_v", "voltage_max_v"), is_mean=True),
    "soc": Quantity("soc", "State of charge [%]", factor=100.0),
    "temperature": Quantity("Surface Temperature / degC", "Battery temperature [°C]"),
}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a quantity over time: its mean as a line, the range it pulses over as a light band.

    Arguments
    ---------
    figure : the card; its options name the quantity.
    data : the charges.

    Returns
    -------
    The figure, a field under the other for each comparison, on common axes.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    quantity, unit_s = QUANTITIES[options.quantity], _SECONDS[options.time_in]
    comparisons = data.shown(figure.comparison)
    drawing = style.figure(0.7 + 2.75 * max(1, len(comparisons)))
    fields = drawing.subplots(max(1, len(comparisons)), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    if not comparisons:
        style.nothing(fields[0], "no charge in this run")
    marks = style.marks(list(data.modes))
    seen: set[str] = set()
    for axes, comparison in zip(fields, comparisons, strict=False):
        axes.set_title(data.comparisons[comparison])
        charged = data.charged(comparison)
        for place, mode in enumerate(charged):
            seen.add(mode)
            trace, later = data.charge(comparison, mode, "trace"), min(3, len(charged) - 1 - place)
            line(axes, trace, quantity, marks[mode], later, unit_s)
            if options.quantity == "soc":
                _soc_marks(axes, data.quantities(comparison, mode), marks[mode], unit_s)
        if options.quantity == "current":
            _supply_limits(axes, data, comparison, marks, unit_s)
        if options.quantity == "temperature":
            _ambient(axes, data, comparison)
    for axes in fields:
        axes.set_ylabel(quantity.label)
    fields[-1].set_xlabel(f"Time [{options.time_in}]")
    titles = {mode: label.title for mode, label in data.modes.items()}
    style.legend(drawing, titles, {mode: mark for mode, mark in marks.items() if mode in seen}, markers=True)
    return drawing


def line(axes: Axes, trace: Columns, quantity: Quantity, mark: style.Mark, later: int, unit_s: float = 3600.0) -> None:
    """Draw one mode, the wider the more modes come later: where they coincide none hides another."""
    moments = trace["Test Time / s"] / unit_s
    if not len(moments):
        return
    if quantity.is_mean:  # a mean over the interval that ends at the row's time stands in its middle
        moments = (moments + np.concatenate([[0.0], moments[:-1]])) / 2.0
    values = quantity.factor * trace[quantity.column]
    if quantity.band:
        low, high = (trace[name] for name in quantity.band)
        if np.max(high - low) > 1e-3 * max(1e-12, float(np.max(np.abs(values)))):
            times, lowest, highest = _blocks(moments, low, high)
            axes.fill_between(times, lowest, highest, color=mark.colour, alpha=0.13, linewidth=0)
    axes.plot(moments, values, color=mark.colour, linestyle=mark.line, linewidth=1.6 + 0.4 * later)
    axes.plot(
        moments[-1:], values[-1:], color=mark.colour, marker=mark.marker, linestyle="", markersize=5.5 + 2.0 * later
    )


def _blocks(
    moments: NDArray[Any], low: NDArray[Any], high: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return the band over fewer, longer intervals; no extreme is lost."""
    starts = np.unique(np.linspace(0, len(moments), _MOST_ROWS_OF_A_BAND, endpoint=False).astype(int))
    return moments[starts], np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _soc_marks(axes: Axes, quantities: dict[str, float], mark: style.Mark, unit_s: float) -> None:
    prefix, suffix = "time_to_soc_", "_s"
    for name, seconds in quantities.items():
        if name.startswith(prefix) and name.endswith(suffix):
            percent = 100.0 * float(name[len(prefix) : -len(suffix)])
            axes.plot(
                [seconds / unit_s],
                [percent],
                linestyle="",
                marker=mark.marker,
                color=mark.colour,
                markerfacecolor="white",
            )


def _supply_limits(axes: Axes, data: ReportData, comparison: str, marks: dict[str, style.Mark], unit_s: float) -> None:
    """Underline the times in which the supply limited the current, a line for each mode it happened to."""
    base = 0.03
    for mode in data.charged(comparison):
        trace = data.charge(comparison, mode, "trace")
        limited = trace["supply_limited_share"] > 0.0
        if np.any(limited):
            moments = trace["Test Time / s"] / unit_s
            axes.fill_between(
                moments, base, base + 0.02, where=limited.tolist(), step="pre", transform=axes.get_xaxis_transform(),
                color=marks[mode].colour, linewidth=0,
            )  # fmt: skip
            base += 0.03
    if base > 0.03:
        axes.text(0.01, base + 0.02, "limited by the supply", transform=axes.transAxes, color=style.GREY, fontsize=9)


def _ambient(axes: Axes, data: ReportData, comparison: str) -> None:
    for mode in data.charged(comparison)[:1]:
        ambient = data.charge(comparison, mode, "trace")["Ambient Temperature / degC"]
        if len(ambient):
            axes.axhline(float(ambient[0]), color=style.GREY, linewidth=1.0, linestyle=":")
            axes.annotate(
                "ambient", (1.0, float(ambient[0])), xycoords=("axes fraction", "data"), xytext=(0, 3),
                textcoords="offset points", ha="right", color=style.GREY, fontsize=9,
            )  # fmt: skip
