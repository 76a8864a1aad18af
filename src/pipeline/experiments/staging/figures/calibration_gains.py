"""How much faster the best currents are than the printed ones under each calibration, and which they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("front",)
Options = NoOptions


_TITLES = {
    "full_entropy": "full\nreversible heat",
    "half_entropy": "half the\nreversible heat",
    "no_entropy": "no\nreversible heat",
    "no_entropy_heavy": "none,\nheavier cell",
}
"""The calibrations of the study; another is called by its name."""
_READINGS = {"peak": ("", "at the same highest rise"), "final": ("//", "at the same rise at the end")}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the time saved on the left, the currents at the same highest rise on the right.

    Arguments
    ---------
    figure : the card.
    data : what the calibrations come to.
    """
    from matplotlib.patches import Patch

    gains, stages = data.table("front", "calibrations"), data.table("front", "calibration_stages")
    names = [str(name) for name in dict.fromkeys(gains["calibration"])]
    drawing = style.figure(4.0)
    saved, currents = drawing.subplots(1, 2)
    for place, (name, mark) in enumerate(zip(names, style.MARKS[: len(names)], strict=False)):
        for offset, (reading, (hatch, _)) in zip((-0.2, 0.2), _READINGS.items(), strict=True):
            row = (gains["calibration"] == name) & (gains["rise"] == reading)
            share = 100.0 * float(gains["saved_share"][row][0])
            saved.barh(place + offset, share, 0.36, **style.filled(style.Part(mark.colour, hatch)))
            saved.text(share + 0.2, place + offset, f"{share:.1f} %", va="center", fontsize=9)
        own = stages["calibration"] == name
        currents.plot(
            stages["stage"][own],
            stages["same_peak_a"][own],
            color=mark.colour,
            linestyle=mark.line,
            marker=mark.marker,
            markersize=5.0 + 1.5 * (len(names) - 1 - place),
            label=_titled(name).replace("\n", " "),
        )
    keys = [Patch(**style.filled(style.Part(style.GREY, hatch)), label=words) for hatch, words in _READINGS.values()]
    drawing.legend(handles=keys, loc="outside upper left", ncols=2, fontsize=9)
    if names:
        first = stages["calibration"] == names[0]
        currents.plot(
            stages["stage"][first], stages["printed_a"][first], **style.PUBLISHED_POINT | {"linestyle": (0, (4, 1.5))}
        )
        currents.text(1.25, float(stages["printed_a"][first][0]) + 0.3, "printed", color=style.PUBLISHED, fontsize=9)
    saved.set_yticks(range(len(names)), [_titled(name) for name in names])
    currents.legend(loc="upper right", fontsize=8.5)
    saved.invert_yaxis()
    saved.grid(False, axis="y")
    saved.set_xlim(0.0, 1.2 * 100.0 * float(np.max(gains["saved_share"], initial=0.01)))
    saved.set_xlabel("Charging time saved [%]")
    currents.set_xlabel("Stage")
    currents.set_ylabel("Current at the same highest rise [A]")
    currents.set_ylim(bottom=0.0)
    return drawing


def _titled(name: str) -> str:
    return _TITLES.get(name, name.replace("_", " "))
