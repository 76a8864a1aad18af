"""Where the heat of each charge came from, mode by mode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("charge",)
Options = NoOptions


_JOULE_PER_WH = 3600.0
_SMALLEST_NAMED_SHARE = 0.005


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the losses of each mode as stacked bars, by path, with their sum.

    Arguments
    ---------
    figure : the card.
    data : the charges' energy tables.

    Returns
    -------
    The figure, a field for each comparison.
    """
    comparisons = data.shown(figure.comparison)
    losses = {(c, m): _losses(data, c, m) for c in comparisons for m in data.charged(c)}
    bars = max([len(data.charged(c)) for c in comparisons], default=1)
    drawing = style.figure(1.25 + max(1, len(comparisons)) * (0.55 + 0.48 * bars))
    fields = drawing.subplots(max(1, len(comparisons)), 1, sharex=True, squeeze=False)[:, 0]
    if not losses:
        style.nothing(fields[0], "no charge in this run")
    named = _named(list(losses.values()))
    colours = {path: style.PARTS[place % len(style.PARTS)] for place, path in enumerate(named)}
    for axes, comparison in zip(fields, comparisons, strict=False):
        axes.set_title(data.comparisons[comparison])
        modes = data.charged(comparison)
        for place, mode in enumerate(modes):
            _bar(axes, place, losses[comparison, mode], colours)
        axes.set_yticks(range(len(modes)), [data.modes[mode].title for mode in modes])
        axes.invert_yaxis()
        axes.grid(False, axis="y")
        axes.margins(x=0.12)
    fields[-1].set_xlabel("Energy turned into heat over the charge [Wh]")
    handles, labels = fields[0].get_legend_handles_labels()
    shown = dict(zip(labels, handles, strict=True))
    if shown:
        drawing.legend(shown.values(), shown.keys(), loc="outside upper center", ncols=3, fontsize=9, handlelength=1.4)
    return drawing


def _losses(data: ReportData, comparison: str, mode: str) -> dict[str, float]:
    energy = data.charge(comparison, mode, "energy")
    rows = energy["role"] == "loss"
    return {
        str(path): float(joule) / _JOULE_PER_WH
        for path, joule in zip(energy["path"][rows], energy["energy_j"][rows], strict=True)
    }


def _named(all_losses: list[dict[str, float]]) -> list[str]:
    """Return the paths worth a colour of their own, in the order of the tables."""
    paths = list(dict.fromkeys(path for losses in all_losses for path in losses))
    largest = max((sum(map(abs, losses.values())) for losses in all_losses), default=0.0)
    return [p for p in paths if max(abs(losses.get(p, 0.0)) for losses in all_losses) > _SMALLEST_NAMED_SHARE * largest]


def _bar(axes: Axes, place: int, losses: dict[str, float], colours: dict[str, str]) -> None:
    ends = {True: 0.0, False: 0.0}
    total = sum(map(abs, losses.values())) or 1.0
    rest = sum(value for path, value in losses.items() if path not in colours)
    parts = [(path, losses.get(path, 0.0), colour) for path, colour in colours.items()]
    if rest:
        parts.append(("all others", rest, "#dddddd"))
    for path, value, colour in parts:
        start = ends[value >= 0]
        axes.barh(place, value, left=start, height=0.62, color=colour, edgecolor="white", label=path)
        ends[value >= 0] += value
        if abs(value) > 0.035 * total:
            axes.text(
                start + value / 2, place, f"{value:.2f}", ha="center", va="center", color=_ink(colour), fontsize=8
            )
    axes.text(ends[True], place, f"  {sum(losses.values()):.2f} Wh", va="center")


def _ink(colour: str) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5))
    lightness = float(np.dot([0.299, 0.587, 0.114], [red, green, blue]))
    return "#000000" if lightness > 0.5 else "#ffffff"
