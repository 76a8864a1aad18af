"""The charging and discharging intervals of Reflex, from the knobs of the mode (Figure 4)."""

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


READS = ("modes",)


class Options(Record):
    """The waveform of one mode, from its knobs."""

    mode: str = Field(default="cv_reflex", min_length=1, description="name of the mode")
    periods: float = Field(default=2.0, ge=1, le=10, description="how many periods are drawn [1]")


_KNOBS = ("charge_a", "charge_share", "discharge_a", "discharge_share", "frequency_hz")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw some periods of the waveform with its intervals.

    Arguments
    ---------
    figure : the card; its options name the mode.
    data : only the modes' labels are read.

    Returns
    -------
    The figure; it says so where the mode is not in the run or lacks a knob.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(3.6)
    axes = drawing.subplots()
    axes.set_xlabel("Time [ms]")
    axes.set_ylabel("Current [A]")
    label = data.modes.get(options.mode)
    missing = [knob for knob in _KNOBS if label is None or knob not in label.knobs]
    if label is None or missing:
        why = f"mode {options.mode} is not in this run" if label is None else "not set: " + ", ".join(missing)
        style.nothing(axes, why)
        return drawing
    charge_a, charge_share, discharge_a, discharge_share, frequency_hz = (float(label.knobs[knob]) for knob in _KNOBS)
    period_ms = 1000.0 / frequency_hz
    edges = np.array([0.0, charge_share, charge_share + discharge_share, 1.0]) * period_ms
    levels = np.array([charge_a, -discharge_a, 0.0])
    _steps(axes, edges, levels, options.periods)
    _intervals(axes, edges, levels)
    axes.set_title(f"{label.title}: {frequency_hz:.4g} Hz, a period of {period_ms:.4g} ms")
    axes.set_ylim(-discharge_a - 0.34 * charge_a, 1.3 * charge_a)
    axes.grid(False)
    return drawing


def _steps(axes: Axes, edges: np.ndarray, levels: np.ndarray, periods: float) -> None:
    mark = style.MARKS[0]
    period_ms = edges[-1]
    count = int(np.ceil(periods))
    time = np.concatenate([np.repeat(edges, 2)[1:-1] + period * period_ms for period in range(count)])
    current = np.tile(np.repeat(levels, 2), count)
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.fill_between(time, np.maximum(current, 0.0), color=mark.colour, alpha=0.13, linewidth=0)
    axes.fill_between(time, np.minimum(current, 0.0), color=style.MARKS[2].colour, alpha=0.3, linewidth=0)
    axes.plot(np.concatenate([[0.0], time]), np.concatenate([[0.0], current]), color=mark.colour)
    axes.set_xlim(-0.02 * period_ms, periods * period_ms)


def _intervals(axes: Axes, edges: np.ndarray, levels: np.ndarray) -> None:
    charge_a, discharge_a = levels[0], -levels[1]
    lengths = np.diff(edges)
    high = 1.12 * charge_a
    arrow = {"arrowstyle": "<->", "color": "#333333", "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (edges[0], high), (edges[1], high), arrowprops=arrow)
    axes.text(
        edges[:2].mean(), high, f"charge $t_1$ = {lengths[0]:.4g} ms, {charge_a:.4g} A\n", ha="center", va="center"
    )
    for line in edges:
        axes.axvline(line, color=style.GREY, linewidth=0.6, linestyle=":")
    texts = (
        f"discharge $t_2$ = {lengths[1]:.3g} ms, {-discharge_a:.3g} A".replace("-", "−"),
        f"rest {lengths[2]:.3g} ms",
    )
    for place, (text, side) in enumerate(zip(texts, ("right", "left"), strict=True), start=1):
        if lengths[place] <= 0:
            continue
        centre = edges[place : place + 2].mean()
        offset = -14 if side == "right" else 14
        axes.annotate(
            text, (centre, levels[place] if place == 1 else 0.0), xytext=(offset, -22 if place == 2 else -16),
            textcoords="offset points", ha=side, va="center",
            arrowprops={"arrowstyle": "-", "color": "#333333", "linewidth": 0.8, "shrinkB": 2},
        )  # fmt: skip
