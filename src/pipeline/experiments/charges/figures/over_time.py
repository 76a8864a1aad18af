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
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("charge",)


class Options(Record):
    """A quantity over the whole charge."""

    quantity: Literal["current", "voltage", "soc", "temperature"]
    time_in: Literal["h", "min", "s"] = Field(default="h", description="unit of the axis of time")
    ends_of: str | None = Field(
        default=None, description="comparison shown by the ends of its charges alone, on the curves of the others"
    )
    top: float | None = Field(default=None, description="where the vertical axis ends; what goes beyond it is told")


_MOST_ROWS_OF_A_BAND = 600
_PULSED_SHARE = 0.05


_SECONDS = {"h": 3600.0, "min": 60.0, "s": 1.0}


class Quantity(NamedTuple):
    """Where a quantity stands in the trace, and how its axis is labelled."""

    column: str
    name: str
    unit: str
    factor: float = 1.0
    band: tuple[str, str] | None = None
    is_mean: bool = False

    @property
    def label(self) -> str:
        """Return the words of its axis."""
        return style.label(self.name, self.unit)


QUANTITIES = {
    "current": Quantity("Current / A", "Current", "A", band=("current_min_a", "current_max_a"), is_mean=True),
    "voltage": Quantity("Voltage / V", "Voltage", "V", band=("voltage_min_v", "voltage_max_v"), is_mean=True),
    "soc": Quantity("soc", "State of charge", "%", factor=100.0),
    "temperature": Quantity("Surface Temperature / degC", "Battery temperature", "°C"),
}
_DIFFERENCES = {"current": "A", "voltage": "V", "soc": "percentage points", "temperature": "K"}
_ALIKE = 0.02
"""Curves that lie closer than this share of what they span are drawn as differences."""
_ENDED_SIZE, _ENDED_EDGE = 11.0, 2.4
"""Size of the symbol where a charge of the other comparison ended, and width of its edge [pt]."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw a quantity over time: its mean as a line, the range it pulses over as a light band.

    Arguments
    ---------
    figure : the card; its options name the quantity.
    data : the charges.

    Returns
    -------
    The figure, a field under the other for each comparison; where the curves of one coincide, what each of them
    differs by from the first.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    quantity, unit_s = QUANTITIES[options.quantity], _SECONDS[options.time_in]
    shown = data.shown(figure.comparison)
    comparisons = [name for name in shown if name != options.ends_of] or shown
    drawing = style.figure(0.9 + (2.75 if len(comparisons) > 1 else 3.2) * max(1, len(comparisons)))
    fields = drawing.subplots(max(1, len(comparisons)), 1, sharex=True, squeeze=False)[:, 0]
    if not comparisons:
        style.nothing(fields[0], "no charge in this run")
    marks = style.marks(list(data.modes))
    keys: dict[str, Artist] = {}
    for axes, comparison in zip(fields, comparisons, strict=False):
        if len(shown) > 1 and len(comparisons) > 1:
            axes.set_title(data.comparisons[comparison])
        if axes is not fields[0] and _coincide(data, comparison, quantity):
            _differences(axes, data, comparison, options.quantity, marks, unit_s)
            continue
        axes.set_ylabel(quantity.label)
        keys |= _curves(axes, data, comparison, options, marks)
        if options.quantity == "current":
            _supply_limits(axes, data, comparison, marks, unit_s)
        if options.ends_of in shown and comparison != options.ends_of:
            keys |= _other_ends(axes, data, (comparison, str(options.ends_of)), quantity, marks, unit_s)
        if options.quantity == "temperature":
            _ambient(axes, data, comparison)
    if not comparisons:
        fields[0].set_ylabel(quantity.label)
    fields[-1].set_xlabel(f"Time [{options.time_in}]")
    seen = {mode for comparison in comparisons for mode in data.charged(comparison)}
    titles = {mode: label.title for mode, label in data.modes.items()}
    found: list[Artist] = list(style.handles(titles, {mode: mark for mode, mark in marks.items() if mode in seen}))
    style.above(drawing, [*found, *keys.values()], size=10.0)
    return drawing


def _curves(
    axes: Axes, data: ReportData, comparison: str, options: Options, marks: dict[str, style.Mark]
) -> dict[str, Artist]:
    """Draw all modes of a comparison; return what else than the modes the legend must tell."""
    quantity, unit_s, keys = QUANTITIES[options.quantity], _SECONDS[options.time_in], {}
    charged = data.charged(comparison)
    for place, mode in enumerate(charged):
        trace, later = data.charge(comparison, mode, "trace"), min(3, len(charged) - 1 - place)
        band = line(axes, trace, quantity, marks[mode], later, unit_s)
        if band is not None:
            keys["band"] = key_of_band()
        end_s = float(trace["Test Time / s"][-1]) if len(trace["Test Time / s"]) else 0.0
        passed = {name: moment for name, moment in data.quantities(comparison, mode).items() if moment < end_s - 1.0}
        if options.quantity == "soc" and _soc_marks(axes, passed, marks[mode], later, unit_s):
            keys["soc"] = _key_of_symbol("a state of charge passed")
    if options.top is not None:
        _cut(axes, data, comparison, quantity, marks, options.top)
    return keys


def key_of_band() -> Artist:
    """Return what a legend shows of the bands over which modes pulse."""
    from matplotlib.patches import Patch

    return Patch(facecolor=style.GREY, alpha=0.3, label="range of the pulses")


def _key_of_symbol(words: str, size: float = 5.5, edge: float = 1.0) -> Artist:
    from matplotlib.lines import Line2D

    return Line2D(
        [], [], linestyle="", marker="o", color=style.GREY, markerfacecolor="white", markersize=size,
        markeredgewidth=edge, label=words,
    )  # fmt: skip


def _moments(trace: Columns, quantity: Quantity, unit_s: float) -> NDArray[Any]:
    """Return where the values stand: a mean over the interval that ends at the row's time stands in its middle."""
    moments: NDArray[Any] = trace["Test Time / s"] / unit_s
    return (moments + np.concatenate([[0.0], moments[:-1]])) / 2.0 if quantity.is_mean else moments


def _differs(
    data: ReportData, comparison: str, mode: str, quantity: Quantity, unit_s: float
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return what a mode's curve differs by from that of the comparison's first, while both charges last."""
    own, first = (data.charge(comparison, one, "trace") for one in (mode, data.charged(comparison)[0]))
    moments, others = _moments(own, quantity, unit_s), _moments(first, quantity, unit_s)
    both = moments <= (others[-1] if len(others) else -np.inf)
    values = quantity.factor * own[quantity.column][both]
    if not np.any(both):
        return moments[both], values
    return moments[both], values - np.interp(moments[both], others, quantity.factor * first[quantity.column])


def _coincide(data: ReportData, comparison: str, quantity: Quantity) -> bool:
    modes = data.charged(comparison)
    traces = [quantity.factor * data.charge(comparison, mode, "trace")[quantity.column] for mode in modes]
    if len(modes) < 2 or not all(len(values) for values in traces):
        return False
    span = max(float(np.ptp(values)) for values in traces)
    apart = [_differs(data, comparison, mode, quantity, 1.0)[1] for mode in modes[1:]]
    return all(float(np.percentile(np.abs(less), 99.0)) <= _ALIKE * span for less in apart if len(less))


def _differences(
    axes: Axes, data: ReportData, comparison: str, name: str, marks: dict[str, style.Mark], unit_s: float
) -> None:
    """Draw what each mode differs by from the first of its comparison."""
    first, *others = data.charged(comparison)
    axes.axhline(0.0, color=marks[first].colour, linewidth=1.2)
    for later, mode in zip(range(len(others) - 1, -1, -1), others, strict=True):
        moments, less = _differs(data, comparison, mode, QUANTITIES[name], unit_s)
        axes.plot(moments, less, color=marks[mode].colour, linestyle=marks[mode].line, linewidth=1.5 + 0.4 * later)
        axes.plot(
            moments[-1:], less[-1:], color=marks[mode].colour, marker=marks[mode].marker, linestyle="",
            markersize=5.5 + 2.0 * min(3, later),
        )  # fmt: skip
    axes.set_title(f"{data.comparisons[comparison]}: the curves coincide, so their differences are drawn")
    axes.set_ylabel(f"Difference from\n{data.modes[first].title} [{_DIFFERENCES[name]}]")


def line(
    axes: Axes, trace: Columns, quantity: Quantity, mark: style.Mark, later: int, unit_s: float = 3600.0
) -> Artist | None:
    """Draw one mode, the wider the more modes come later: where they coincide none hides another.

    Returns
    -------
    The band over which it pulses, where there is one.
    """
    if not len(trace["Test Time / s"]):
        return None
    moments, values, band = _moments(trace, quantity, unit_s), quantity.factor * trace[quantity.column], None
    if quantity.band:
        low, high = (trace[name] for name in quantity.band)
        # A jump within one interval is no pulse.
        is_pulsed = high - low > 1e-3 * max(1e-12, float(np.max(np.abs(values))))
        if np.count_nonzero(is_pulsed) > _PULSED_SHARE * len(values):
            times, lowest, highest = _blocks(moments, low, high)
            band = axes.fill_between(times, lowest, highest, color=mark.colour, alpha=0.13, linewidth=0)
    at, drawn = moments, values
    if quantity.name == "Current" and quantity.band:
        at, drawn = style.stepped(trace["Test Time / s"] / unit_s, values, *(trace[name] for name in quantity.band))
    axes.plot(at, drawn, color=mark.colour, linestyle=mark.line,
              linewidth=1.6 + 0.4 * later)  # fmt: skip
    axes.plot(
        moments[-1:], values[-1:], color=mark.colour, marker=mark.marker, linestyle="", markersize=5.5 + 2.0 * later
    )
    return band


def _cut(
    axes: Axes, data: ReportData, comparison: str, quantity: Quantity, marks: dict[str, style.Mark], top: float
) -> None:
    """End the axis at `top`, and say how far each curve goes that leaves there."""
    words, colour = [], style.INK
    for mode in data.charged(comparison):
        values = quantity.factor * data.charge(comparison, mode, "trace")[quantity.column]
        if len(values) and float(np.max(values)) > top:
            words.append(f"{data.modes[mode].title}: to {float(np.max(values)):.1f} {quantity.unit}")
            colour = marks[mode].colour
    axes.set_ylim(top=top)
    if words:
        axes.text(
            0.99, 0.97, "\n".join(words), transform=axes.transAxes, ha="right", va="top", fontsize=9, color=colour
        )


def _other_ends(
    axes: Axes,
    data: ReportData,
    comparisons: tuple[str, str],
    quantity: Quantity,
    marks: dict[str, style.Mark],
    unit_s: float,
) -> dict[str, Artist]:
    """Mark on the curves of one comparison where those of another end that end earlier."""
    longer, shorter = comparisons
    found: dict[str, Artist] = {}
    for mode in data.charged(shorter):
        trace, whole = data.charge(shorter, mode, "trace"), data.charge(longer, mode, "trace")
        if not len(trace["Test Time / s"]) or trace["Test Time / s"][-1] >= whole["Test Time / s"][-1] - 1e-6:
            continue
        moments, values = _moments(trace, quantity, unit_s), quantity.factor * trace[quantity.column]
        axes.plot(
            moments[-1:], values[-1:], color=marks[mode].colour, marker=marks[mode].marker, linestyle="",
            markerfacecolor="white", markersize=_ENDED_SIZE, markeredgewidth=_ENDED_EDGE, zorder=4,
        )  # fmt: skip
        found["ends"] = _key_of_symbol(data.comparisons[shorter], 8.0, _ENDED_EDGE)
    return found


def _blocks(
    moments: NDArray[Any], low: NDArray[Any], high: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return the band over fewer, longer intervals; no extreme is lost."""
    starts = np.unique(np.linspace(0, len(moments), _MOST_ROWS_OF_A_BAND, endpoint=False).astype(int))
    return moments[starts], np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _soc_marks(axes: Axes, quantities: dict[str, float], mark: style.Mark, later: int, unit_s: float) -> bool:
    prefix, suffix = "time_to_soc_", "_s"
    reached = [
        (seconds / unit_s, 100.0 * float(name[len(prefix) : -len(suffix)]))
        for name, seconds in quantities.items()
        if name.startswith(prefix) and name.endswith(suffix)
    ]
    if reached:
        axes.plot(
            *zip(*reached, strict=True), linestyle="", marker=mark.marker, color=mark.colour, markerfacecolor="white",
            markersize=5.5 + 2.0 * later,
        )  # fmt: skip
    return bool(reached)


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
