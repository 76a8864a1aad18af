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
    drawing = style.figure(3.6)
    axes = drawing.subplots()
    axes.set_axis_off()
    if settings.get("kind") != "cuckoo":
        style.nothing(axes, "the search of this run is no cuckoo search")
        return drawing
    chart = Circuit(axes)
    used = style.MARKS[0].colour
    chart.box((0.0, 0.0), 2.8, 1.3, "best nest\n(reference)")
    chart.box((3.9, 0.0), 2.0, 1.3, "e = best\n- X", round_by=0.5)
    chart.box(
        (10.4, 2.3),
        8.2,
        1.5,
        f"P: Kp e, with Kp = -L x {settings['step_scale']:g}\nL: a Lévy number times a normal one",
    )
    integral = f"Ki = {settings['ki']:g}, leak = {settings['leak']:g}" if settings["ki"] > 0 else "Ki = 0: left out"
    chart.box((10.4, 0.0), 8.2, 1.5, f"I: Ki (e + leak e' + leak² e'' + ...)\n{integral}", used)
    chart.box((10.4, -2.1), 8.2, 1.0, "D: none", "#b8b8b8")
    end = settings["inertia_end"]
    falls = "" if end is None else f" falling to {end:g}"
    chart.box((18.4, 0.0), 4.6, 1.5, f"X = w X + P + I\nw = {settings['inertia']:g}{falls}")
    chart.box((24.0, 0.0), 3.4, 1.5, "kept where\nno worse")
    chart.arrow((1.4, 0.0), (2.9, 0.0))
    chart.arrow((4.9, 0.0), (6.3, 0.0))
    chart.arrow((5.5, 0.0), (5.5, 2.3), ends_at=(6.3, 2.3))
    chart.arrow((14.5, 2.3), (18.4, 2.3), ends_at=(18.4, 0.75))
    chart.arrow((14.5, 0.0), (16.1, 0.0))
    chart.arrow((20.7, 0.0), (22.3, 0.0))
    chart.arrow((25.7, 0.0), (27.6, 0.0), "X")
    axes.plot([26.6, 26.6, 3.9], [0.0, -3.4, -3.4], color="#222222", linewidth=1.3, zorder=2)
    chart.arrow((3.9, -3.4), (3.9, -0.65))
    chart.done((-1.8, 28.2), (-3.8, 3.4))
    return drawing
