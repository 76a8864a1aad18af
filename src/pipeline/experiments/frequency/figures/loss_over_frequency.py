"""Loss against the frequency of the pulses: its parts, the optimum, and how little it matters close to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("objective",)
Options = NoOptions


_MILLI = 1e3
_ZOOM = 2.2


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the loss by parts over frequency, and the integral square error about its minimum.

    Arguments
    ---------
    figure : the card.
    data : the objective's loss and named numbers.

    Returns
    -------
    The figure, what frequency cannot change as level lines.
    """
    loss, numbers = data.table("objective", "loss"), data.numbers("objective")
    drawing = style.figure(4.6)
    whole, close = drawing.subplots(1, 2, width_ratios=(1.75, 1.0))
    _parts(whole, loss, numbers)
    _flatness(close, loss, numbers)
    style.above(drawing, *whole.get_legend_handles_labels())
    return drawing


def _parts(axes: Axes, loss: Columns, numbers: dict[str, float]) -> None:
    frequency = loss["frequency_hz"]
    changing = loss["pair_ripple_w"] + loss["switching_w"]
    curves = (("ripple in the RC pairs", loss["pair_ripple_w"]), ("switches", loss["switching_w"]),
              ("sum of both", changing))  # fmt: skip
    for (label, values), mark, width in zip(curves, style.MARKS, (1.3, 1.3, 2.2), strict=False):
        axes.plot(frequency, _MILLI * values, color=mark.colour, linestyle=mark.line, linewidth=width, label=label)
    levels = {
        "ripple in the series resistance": (float(loss["series_ripple_w"][0]), "bottom"),
        "mean current": (numbers.get("mean_current_w", np.nan), "top"),
        "discharge resistor": (numbers.get("discharge_resistor_w", np.nan), "bottom"),
    }
    for (label, (value, side)), mark in zip(levels.items(), style.MARKS[3:], strict=False):
        axes.axhline(_MILLI * value, color=mark.colour, linewidth=1.2, linestyle=mark.line)
        axes.annotate(
            f"{label}, at any frequency", (0.99, _MILLI * value), xycoords=("axes fraction", "data"),
            xytext=(0, 2 if side == "bottom" else -3), textcoords="offset points", ha="right", va=side, fontsize=8.5,
            color=mark.colour,
        )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(1e-3, 3e3)
    for name, value in _places(numbers).items():
        _place(axes, name, value, float(np.interp(value, frequency, _MILLI * changing)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("Frequency of the pulses [Hz]")
    axes.set_ylabel("Loss [mW]")
    axes.set_title("Loss by part")


def _places(numbers: dict[str, float]) -> dict[str, float]:
    """Return the frequencies [Hz] that are marked; the classic one from the power its switches take."""
    energy = numbers.get("switching_energy_j", np.nan)
    found = {
        "classic": numbers.get("switching_at_classic_w", np.nan) / energy if energy else np.nan,
        "optimum": numbers.get("optimal_frequency_hz", np.nan),
        "least impedance": numbers.get("impedance_minimum_hz", np.nan),
    }
    return {name: value for name, value in found.items() if np.isfinite(value) and value > 0.0}


_WORDS = {
    "classic": ("a documented\nReflex charger", (0, -30), "left", "top"),
    "optimum": ("optimum", (0, 26), "center", "bottom"),
    "least impedance": ("least impedance", (24, -34), "right", "top"),
}


def _place(axes: Axes, name: str, frequency_hz: float, loss_mw: float) -> None:
    words, offset, side, level = _WORDS[name]
    axes.plot(frequency_hz, loss_mw, "o", color="#222222", markersize=6, zorder=5)
    number = f"{frequency_hz:.3g}" if frequency_hz < 100 else f"{frequency_hz:.4g}"
    axes.annotate(
        f"{words}: {number} Hz" if name == "classic" else f"{words}\n{number} Hz", (frequency_hz, loss_mw),
        xytext=offset, textcoords="offset points", ha=side, va=level, fontsize=9,
        arrowprops={"arrowstyle": "-", "color": "#222222", "linewidth": 0.7},
    )  # fmt: skip


def _flatness(axes: Axes, loss: Columns, numbers: dict[str, float]) -> None:
    best = numbers.get("optimal_frequency_hz", np.nan)
    axes.set_xlabel("Frequency of the pulses [Hz]")
    axes.set_ylabel("ISE above its minimum [%]")
    axes.set_title("Close to the optimum")
    if not np.isfinite(best):
        style.nothing(axes, "no optimum between 1 mHz and 1 MHz")
        return
    near = (loss["frequency_hz"] >= best / _ZOOM) & (loss["frequency_hz"] <= best * _ZOOM)
    axes.plot(loss["frequency_hz"][near], 100.0 * loss["share_over_minimum"][near], color=style.MARKS[2].colour)
    low, high = numbers.get("band_low_hz", np.nan), numbers.get("band_high_hz", np.nan)
    axes.axvspan(low, high, color=style.MARKS[0].colour, alpha=0.15, linewidth=0)
    share = 100.0 * float(np.interp(high, loss["frequency_hz"], loss["share_over_minimum"]))
    axes.plot(best, 0.0, "o", color="#222222", markersize=6, zorder=5)
    axes.text(
        0.5, 0.97, f"{best:.1f} Hz; within {share:.1g} %\nfrom {low:.0f} to {high:.0f} Hz",
        transform=axes.transAxes, ha="center", va="top", fontsize=9,
    )  # fmt: skip
