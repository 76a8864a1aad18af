"""The page's sections on the solar supply."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.report.converter_tables import converter_check, converter_table, converter_text
from pipeline.report.data import ReportData
from pipeline.report.pages import PageFigure, PageSection, prose
from pipeline.report.supply_tables import panel_fit, tracking_tables, tracking_text


def sections(data: ReportData, trackers: Sequence[PageFigure], converters: Sequence[PageFigure]) -> list[PageSection]:
    """Return the sections on the panel's model, trackers and converters; none where the run has no panel.

    Arguments
    ---------
    data : the run's artefacts.
    trackers, converters : the figures that show them.
    """
    if not data.holds("panel", "panel_fit"):
        return []
    text = "How well the single-diode model that every charge is fed from meets the values it was made from."
    found = [PageSection("panel-model", "The panel and its model", text, [panel_fit(data)])]
    if "tracking" in data.inputs:
        tables = tracking_tables(data)
        found.append(PageSection("trackers-tried", "The trackers", prose(tracking_text(data)), tables, trackers))
    if "converters" in data.inputs:
        shown = [converter_table(data), converter_check(data)]
        found.append(PageSection("converters-by-load", "The converters", converter_text(data), shown, converters))
    return found
