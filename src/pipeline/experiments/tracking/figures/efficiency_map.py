"""The efficiency of both converters over load, their losses by path, and the switches' answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("converters",)
Options = NoOptions


_PATHS = {
    "switch_w": "switch",
    "rectifier_w": "rectifier",
    "winding_w": "inductor winding",
    "core_w": "inductor core",
    "capacitor_w": "output capacitor",
    "switching_w": "switching",
    "control_w": "control",
}
_SEEN_PERCENT = 0.5
"""A layer that is nowhere thicker than this share of the input is told in words."""
_VARIED = {"boost": ("source_v", "panel"), "buck": ("sink_v", "battery")}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw efficiency over input power for some voltages, and below it the losses at the middle one.

    Arguments
    ---------
    figure : the card.
    data : the converters' efficiency.

    Returns
    -------
    The figure, the boost converter on the left; it says so where the run does not know the parts.
    """
    drawing = style.figure(6.2)
    if "converters" not in data.inputs:
        style.nothing(
            drawing.subplots(),
            "the converters are known by their efficiency alone",
            "Input power [W]",
            "Efficiency [%]",
        )
        return drawing
    fields = drawing.subplots(2, 2, sharex="col", sharey="row")
    found = data.table("converters", "efficiency")
    check = data.table("converters", "check")
    for column, which in enumerate(_VARIED):
        own = {name: values[found["converter"] == which] for name, values in found.items()}
        if len(own["power_w"]) == 0:
            style.nothing(fields[0, column], "not possible at these voltages")
            continue
        seen = {name: values[check["converter"] == which] for name, values in check.items()}
        _efficiency(fields[0, column], own, seen, which)
        _losses(fields[1, column], own, which)
        fields[1, column].set_xlabel("Input power [W]")
        fields[1, column].xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    fields[0, 0].set_ylabel("Efficiency [%]")
    fields[1, 0].set_ylabel("Losses [% of the input]")
    handles, _ = fields[1, 1].get_legend_handles_labels()
    names = [_most(found, path) for path in _PATHS]
    if handles:
        drawing.legend(handles, names, loc="outside lower center", ncols=4, fontsize=9, handlelength=2.0)
    return drawing


def _efficiency(axes: Axes, own: Columns, seen: Columns, which: str) -> None:
    name, words = _VARIED[which]
    voltages = np.unique(own[name])
    for voltage, mark in zip(voltages, style.MARKS, strict=False):
        at = own[name] == voltage
        label = f"{words} at {voltage:.1f} V"
        axes.semilogx(
            own["power_w"][at], 100.0 * own["efficiency"][at], color=mark.colour, linestyle=mark.line, label=label
        )
    axes.semilogx(
        seen["power_w"], 100.0 * seen["averaged"], color=style.GREY, linewidth=1.0, label="conduction alone, averaged"
    )
    axes.semilogx(
        seen["power_w"], 100.0 * seen["switched"], "x", color=style.GREY, label="conduction alone, switch by switch"
    )
    axes.set_title(f"{which.capitalize()} converter")
    axes.set_ylim(70.0, 100.0)
    axes.legend(fontsize=8.5, loc="lower right")


def _losses(axes: Axes, own: Columns, which: str) -> None:
    name, _ = _VARIED[which]
    voltages = np.unique(own[name])
    at = own[name] == voltages[len(voltages) // 2]
    below = np.zeros(np.count_nonzero(at))
    for (path, words), part in zip(_PATHS.items(), style.PARTS, strict=False):
        above = below + 100.0 * own[path][at] / own["power_w"][at]
        axes.fill_between(own["power_w"][at], below, above, label=words, **style.filled(part))
        below = above
    axes.set_ylim(bottom=0.0)


def _most(found: Columns, path: str) -> str:
    """Return how a path is called, with its largest share where that is too thin a layer to be seen."""
    most = 100.0 * float(np.max(found[path] / found["power_w"]))
    return f"{_PATHS[path]}, at most {most:.1g} %" if most < _SEEN_PERCENT else _PATHS[path]
