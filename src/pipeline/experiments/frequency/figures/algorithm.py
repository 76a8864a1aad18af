"""The search as it is run, a flow chart from its settings (Figure 6)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.circuit_parts import Circuit
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("algorithm", "search")


class Options(Record):
    """The search, beside what the paper chose."""

    published: dict[str, float] = Field(default_factory=dict, description="name of a constant -> what the paper chose")


_RAND = {
    "logistic": "two orbits of the logistic map at r = 4",
    "uniform": "two independent uniform numbers",
    "arcsine": "two independent numbers of the map's density",
}
_WALL = {"clamp": "stop at the wall", "reflect": "come back from the wall"}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the swarm's course from start to result.

    Arguments
    ---------
    figure : the card.
    data : the settings of the search, and what it found.

    Returns
    -------
    The figure; it says so where the search is no swarm.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    settings = data.settings.get("algorithm", {})
    drawing = style.figure(4.9)
    axes = drawing.subplots()
    axes.set_axis_off()
    if settings.get("kind") != "swarm":
        style.nothing(axes, "the search of this run is no swarm")
        return drawing
    chart = Circuit(axes)
    _boxes(chart, settings, data.numbers("search").get("frequency_hz", np.nan))
    _arrows(chart)
    if options.published:
        words = ", ".join(f"{name.upper()} = {value:g}" for name, value in options.published.items())
        chart.text((10.5, 4.8), f"the paper chose {words}", "left", colour=style.PUBLISHED)
    chart.done((-4.4, 15.4), (-1.9, 9.4))
    return drawing


def _boxes(chart: Circuit, settings: Mapping[str, Any], found_hz: float) -> None:
    ranges = ", ".join(
        f"{name.removesuffix('_hz')} {edges['low']:g} to {edges['high']:g}{' Hz' if name.endswith('_hz') else ''}"
        for name, edges in settings["variables"].items()
    )
    start = f"{settings['particles']} particles at rest,\nat random places: {ranges}"
    left = {
        8.4: start,
        6.0: "Value of every particle: ISE, eq. (5)",
        3.6: "Keep what is better:\npbest of each particle, gbest of all",
    }
    for height, words in left.items():
        chart.box((0.0, height), 8.0, 1.5, words)
    chart.box((0.0, 1.2), 8.0, 1.3, f"Moved {settings['iterations']} times?", style.MARKS[2].colour, 0.6)
    chart.box((0.0, -1.2), 8.0, 1.1, f"gbest; best of {settings['replicates']} searches: {found_hz:.4g} Hz",
              style.MARKS[0].colour, 0.5)  # fmt: skip
    right = {
        1.2: f"Rand, for every particle:\n{_RAND.get(settings['rand'], settings['rand'])}, eq. (4)",
        3.6: "V = W V + C1 Rand (pbest - X) + C2 Rand (gbest - X), eq. (2)\n"
        + ", ".join(f"{name.upper()} = {settings[name]:g}" for name in ("c1", "c2", "w"))
        + f"; |V| at most {settings['velocity_limit']:g} of the range",
        6.0: f"X = X + V, eq. (3);\n{_WALL.get(settings['position_limit'], settings['position_limit'])}",
    }
    for height, words in right.items():
        chart.box((10.2, height), 10.2, 1.5, words)


def _arrows(chart: Circuit) -> None:
    for top, bottom in ((7.65, 6.75), (5.25, 4.35), (2.85, 1.85)):
        chart.arrow((0.0, top), (0.0, bottom))
    chart.arrow((0.0, 0.55), (0.0, -0.65), "yes", beside=True)
    chart.arrow((4.0, 1.2), (5.1, 1.2), "no")
    for bottom, top in ((1.95, 2.85), (4.35, 5.25)):
        chart.arrow((10.2, bottom), (10.2, top))
    chart.arrow((5.1, 6.0), (4.0, 6.0))
