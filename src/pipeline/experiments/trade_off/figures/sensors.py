"""What the sensor makes of the network and of the plain rule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("trade_off",)
Options = NoOptions
_FIELDS = (
    ("time_to_full_s", 1.0 / 60.0, "Time until charged [min]"),
    ("end_soc", 100.0, "State of charge at the end [%]"),
    ("peak_temperature_c", 1.0, "Peak temperature [°C]"),
)


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw what each mode that samples reaches behind each sensor: a row a sensor, a field a quantity.

    Arguments
    ---------
    figure : the card.
    data : the trade-off, and its settings for the titles of the sensors.

    Returns
    -------
    The figure; where it never is charged, that is said at the edge.
    """
    if "trade_off" not in data.inputs:
        drawing = style.figure(3.0)
        style.nothing(drawing.subplots(), "no trade-off in this run")
        return drawing
    table = data.table("trade_off", "trade_off")
    titles: Mapping[str, Any] = data.settings.get("trade_off", {}).get("sensors", {})
    sensors = ["own", *dict.fromkeys(str(name) for name in table["sensor"] if name not in ("", "own"))]
    modes = [mode for mode in data.modes if mode in table["law"]]
    marks = style.marks(list(data.modes))
    drawing = style.figure(1.3 + 0.5 * len(sensors))
    fields = drawing.subplots(1, len(_FIELDS), sharey=True)
    for axes, (column, factor, label) in zip(fields, _FIELDS, strict=True):
        for place, mode in enumerate(modes):
            first = (table["law"] == mode) & (table["condition"] == table["condition"][0])
            values = [_of(table[column][first & (table["sensor"] == sensor)]) for sensor in sensors]
            heights = np.arange(len(sensors)) + 0.2 * (place - (len(modes) - 1) / 2)
            shown = factor * np.array(values)
            mark = marks[mode]
            axes.plot(shown, heights, linestyle="", marker=mark.marker, color=mark.colour, markersize=7)
            never = ~np.isfinite(shown)
            for height in heights[never]:
                axes.annotate(
                    "never", (0.98, float(height)), xycoords=axes.get_yaxis_transform(), ha="right", va="center",
                    fontsize=9, fontweight="bold", color=mark.colour,
                )  # fmt: skip
        axes.set_xlabel(label)
        axes.set_xmargin(0.12)
        if column == "time_to_full_s":
            axes.set_xlim(0.0, 1.4 * factor * float(np.nanmax(table[column][np.isin(table["law"], modes)])))
    names = ["ideal, 1 s"] + [titles.get(name, {}).get("title", name) for name in sensors[1:]]
    fields[0].set_yticks(range(len(sensors)), names)
    fields[0].set_ylim(len(sensors) - 0.5, -0.5)
    handles = style.handles({mode: data.modes[mode].title for mode in modes}, {mode: marks[mode] for mode in modes})
    for handle in handles:
        handle.set_linestyle("")
    style.above(drawing, handles, size=10.0)
    return drawing


def _of(found: Any) -> float:
    return float(found[0]) if len(found) else float("nan")
