"""Cuckoo search as a control loop with the configured constants (Figure 4)."""

from __future__ import annotations

from matplotlib.figure import Figure

from pipeline.report import style
from pipeline.report.data import ReportData
from pipeline.report.figures.circuit_parts import Circuit
from pipeline.report.records import FigureCard


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
    drawing = style.figure(3.6)
    axes = drawing.subplots()
    axes.set_axis_off()
    if settings.get("kind") != "cuckoo":
        style.nothing(axes, "the search of this run is no cuckoo search")
        return drawing
    chart = Circuit(axes)
    used = style.MARKS[0].colour
    chart.box((0.0, 0.0), 2.6, 1.2, "best nest\n(reference)")
    chart.box((3.6, 0.0), 1.3, 1.2, "e = best - X", round_by=0.5)
    axes.texts[-1].set_text("- X")
    chart.box((8.2, 2.2), 5.4, 1.3, "P: Kp e,  Kp = -step L, L a Lévy number\n" + f"step {settings['step_scale']:g}")
    integral = f"Ki = {settings['ki']:g}, leak {settings['leak']:g}" if settings["ki"] > 0 else "Ki = 0: left out"
    chart.box((8.2, 0.0), 5.4, 1.3, f"I: Ki (e + leak e' + leak² e'' + ...)\n{integral}", used)
    chart.box((8.2, -2.2), 5.4, 1.1, "D: none, whatever the title says", "#b8b8b8")
    end = settings["inertia_end"]
    falls = "" if end is None else f" falling to {end:g}"
    chart.box((15.2, 0.0), 4.2, 1.3, f"X = w X + P + I\nw = {settings['inertia']:g}{falls}")
    chart.box((20.6, 0.0), 3.4, 1.3, "kept where\nno worse")
    chart.arrow((1.3, 0.0), (2.95, 0.0))
    chart.arrow((4.25, 0.0), (5.5, 0.0), "e")
    for height in (2.2,):
        chart.arrow((4.85, 0.0), (4.85, height), ends_at=(5.5, height))
        chart.arrow((10.9, height), (15.2, height), ends_at=(15.2, 0.65))
    chart.arrow((10.9, 0.0), (13.1, 0.0))
    chart.arrow((17.3, 0.0), (18.9, 0.0))
    chart.arrow((22.3, 0.0), (23.6, 0.0), "X")
    axes.plot([23.0, 23.0, 3.6], [0.0, -3.4, -3.4], color="#222222", linewidth=1.3, zorder=2)
    chart.arrow((3.6, -3.4), (3.6, -0.6))
    chart.done((-1.6, 24.4), (-3.8, 3.2))
    return drawing
