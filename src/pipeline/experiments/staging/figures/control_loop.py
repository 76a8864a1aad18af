"""Cuckoo search as a control loop with the configured constants (Figure 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.report import style
from pipeline.report.circuit_parts import Circuit
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("stage_search",)
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the loop from the best nest to the nest that follows it.

    Arguments
    ---------
    figure : the card.
    data : settings of the search that is used.

    Returns
    -------
    The figure; it says so where that search is no cuckoo search.
    """
    settings = data.settings.get("stage_search", {})
    drawing = style.figure(2.2)
    axes = drawing.subplots()
    axes.set_axis_off()
    if settings.get("kind") != "cuckoo":
        style.nothing(axes, "the search of this run is no cuckoo search")
        return drawing
    chart = Circuit(axes)
    used = style.MARKS[0].colour
    chart.box((0.0, 0.0), 3.4, 1.6, "best nest\n(reference)")
    chart.box((5.2, 0.0), 3.6, 1.6, "e =\nbest - X", round_by=0.5)
    proportional = f"P: Kp e, with Kp = −L × {settings['step_scale']:g}\nL: Lévy number × normal number"
    chart.box((14.2, 2.6), 10.4, 1.7, proportional)
    integral = f"Ki = {settings['ki']:g}, leak = {settings['leak']:g}" if settings["ki"] > 0 else "Ki = 0: left out"
    chart.box((14.2, 0.0), 10.4, 1.7, f"I: Ki (e + leak e' + leak² e'' + ...)\n{integral}", used)
    chart.box((14.2, -2.2), 10.4, 1.1, "D: none", "#8a8a8a")
    end = settings["inertia_end"]
    falls = "" if end is None else f", falling to {end:g}"
    chart.box((24.6, 0.0), 6.4, 1.7, f"X = w X + P + I\nw = {settings['inertia']:g}{falls}")
    chart.box((31.4, 0.0), 4.2, 1.7, "kept where\nno worse")
    chart.arrow((1.7, 0.0), (3.4, 0.0))
    chart.arrow((7.0, 0.0), (9.0, 0.0))
    chart.arrow((7.9, 0.0), (7.9, 2.6), ends_at=(9.0, 2.6))
    chart.arrow((19.4, 2.6), (24.6, 2.6), ends_at=(24.6, 0.85))
    chart.arrow((19.4, 0.0), (21.4, 0.0))
    chart.arrow((27.8, 0.0), (29.3, 0.0))
    chart.arrow((33.5, 0.0), (35.6, 0.0), "X")
    axes.plot([34.6, 34.6, 5.2], [0.0, -3.4, -3.4], color="#222222", linewidth=1.3, zorder=2)
    chart.arrow((5.2, -3.4), (5.2, -0.8))
    chart.done((-2.0, 36.0), (-3.7, 3.7))
    return drawing
