"""The panel on the page: Table 1 of the paper, and the panel's model beside its data sheet."""

from __future__ import annotations

import csv
from collections.abc import Sequence

from pipeline.published.reference import REFERENCE
from pipeline.record import NOT_GIVEN
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable

LABELS = ()
PRINTED = REFERENCE / "solar_table1.csv"
_STANDARD = (1000.0, 25.0)
_TABLE_1 = (
    ("maximum power", "W", "p_max_w", "max_power_w"),
    ("voltage at maximum power", "V", "v_mp_v", "max_power_voltage_v"),
    ("current at maximum power", "A", "i_mp_a", "max_power_current_a"),
    ("open-circuit voltage", "V", "v_oc_v", "open_circuit_voltage_v"),
    ("short-circuit current", "A", "i_sc_a", "short_circuit_current_a"),
)


def tables(data: ReportData) -> list[ReportTable]:
    """Return the paper's Table 1; none where the run has no panel."""
    return [table_1(data)] if "panel" in data.inputs else []


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the section on the panel's model; none where the run has no panel."""
    if "panel" not in data.inputs:
        return []
    text = "How well the single-diode model that every charge is fed from meets the values it was made from."
    shown = [panel_fit(data), *files(data)]
    return [PageSection("panel-model", "The panel and its model", " ".join([text, *estimated(data)]), shown)]


def estimated(data: ReportData) -> list[str]:
    """Return in a sentence which values of the panel stand on no data sheet; nothing where all do."""
    absent = [one for one in data.parameters if one.key.startswith("panel.") and one.reference.startswith(NOT_GIVEN)]
    if not absent:
        return []
    values = "; ".join(
        f"{one.key} {f'{one.value:.4g} {one.unit}'.rstrip()} ({one.low:.4g} to {one.high:.4g})" for one in absent
    )
    return [f"Not on its data sheet, and so usual values, in which nine of ten modules lie in the range: {values}."]


def files(data: ReportData) -> list[ReportTable]:
    """Return the table of what the weather's file was taken for; none where the weather stands in no file."""
    notes = data.table("supply", "notes")["note"]
    if not len(notes):
        return []
    return [
        ReportTable(
            "weather_file",
            "The weather's file",
            "What the file was taken for, and what was done to its values; every guess is a key of the configuration.",
            ("what was found",),
            tuple((note,) for note in notes),
        )
    ]


def table_1(data: ReportData) -> ReportTable:
    """Return the panel's characteristic values, printed and computed."""
    with PRINTED.open(encoding="utf-8", newline="") as file:
        paper = next(csv.DictReader(file))
    points = data.table("panel", "points")
    conditions = zip(points["irradiance_w_m2"], points["cell_temperature_c"], strict=True)
    row = next((place for place, found in enumerate(conditions) if found == _STANDARD), None)
    rows = []
    for title, unit, theirs, ours in _TABLE_1:
        value = float(paper[theirs])
        computed = None if row is None else float(points[ours][row])
        deviation = None if computed is None else 100.0 * (computed / value - 1.0)
        rows.append((title, unit, value, computed, deviation))
    return ReportTable(
        "table_1",
        "Panel at 1000 W/m² and 25 °C",
        "The single-diode model is fitted to the voltages and currents, so these agree by construction; "
        "the power is their product.",
        ("quantity", "unit", "printed", "computed", "deviation / %"),
        tuple(rows),
        paper="Table 1",
    )


def panel_fit(data: ReportData) -> ReportTable:
    """Return the values of the panel's data sheet beside those of its single-diode model."""
    found = data.table("panel", "fit")
    rows: list[tuple[Cell, ...]] = []
    for quantity, unit, sheet, model in zip(*(found[name] for name in found), strict=True):
        error = 100.0 * (float(model) / float(sheet) - 1.0) if sheet else None
        rows.append((str(quantity), str(unit), float(sheet), float(model), error))
    return ReportTable(
        "panel_fit",
        "The panel's model beside its data sheet",
        "One panel at 1000 W/m² and 25 °C. The model moves both coefficients at the axes together, by its adjustment, "
        "so that the maximum power has the coefficient of the sheet.",
        ("quantity", "unit", "data sheet", "model", "deviation / %"),
        tuple(rows),
    )
