"""Where the panel's power goes before it reaches the battery."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import Columns, ReportData


READS = ("supply",)
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the powers from the panel to the battery: as steps where they are constant, over time where not.

    Arguments
    ---------
    figure : the card.
    data : the supply.

    Returns
    -------
    The figure.
    """
    supply = data.table("supply", "supply")
    drawing = style.figure(3.4)
    axes = drawing.subplots()
    if len(supply["time_s"]) == 1:
        _cascade(axes, {name: float(values[0]) for name, values in supply.items()})
    else:
        _over_time(axes, supply)
    return drawing


def _cascade(axes: Axes, supply: dict[str, float]) -> None:
    boost_input = supply["bus_power_w"] / supply["boost_efficiency"]
    left = supply["battery_power_w"] / supply["buck_efficiency"]
    served = supply["bus_power_w"] - left
    levels = [
        ("panel at maximum power", 0.0, supply["panel_power_w"], True),
        ("not tracked", boost_input, supply["panel_power_w"], False),
        ("boost converter", supply["bus_power_w"], boost_input, False),
        ("master system", supply["bus_power_w"] - served, supply["bus_power_w"], False),
        ("buck converter", supply["battery_power_w"], left, False),
        ("available to the battery", 0.0, supply["battery_power_w"], True),
    ]
    for place, (_, low, high, is_level) in enumerate(levels):
        look = style.filled(style.PARTS[0] if is_level else style.Part(style.PARTS[2].colour, "//"))
        axes.barh(place, high - low, left=low, height=0.62, **look)
        sign = "" if is_level else "\N{MINUS SIGN}"
        axes.text(high, place, f"  {sign}{high - low:.2f} W", va="center")
    axes.set_yticks(range(len(levels)), [name for name, *_ in levels])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.13 * supply["panel_power_w"])
    axes.set_xlabel("Power [W]")
    axes.set_title(f"{supply['irradiance_w_m2']:g} W/m², cells at {supply['cell_temperature_c']:g} °C")
    axes.grid(False, axis="y")


def _over_time(axes: Axes, supply: Columns) -> None:
    hours = supply["time_s"] / 3600.0
    names = {
        "panel_power_w": "panel",
        "bus_power_w": "bus",
        "load_power_w": "master system",
        "battery_power_w": "battery",
    }
    for (name, title), mark in zip(names.items(), style.MARKS, strict=False):
        axes.step(hours, supply[name], where="post", color=mark.colour, linestyle=mark.line, label=title)
    axes.legend(ncols=len(names), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axes.set_xlabel("Time [h]")
    axes.set_ylabel("Power [W]")
    axes.set_ylim(bottom=min(0.0, float(np.min(supply["battery_power_w"]))))
