"""The section on the second battery: its words and tables follow from the artefacts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline import quantity, schemas, tables
from pipeline.report import second_cell
from pipeline.report.data import ReportData
from pipeline.report.pages import PageContent, PageFigure, PageSection, render
from pipeline.report.search_tables import beyond_range
from tests.report_pages.conftest import SVG, verdict_columns, write_charge
from tests.report_pages.test_pages import Page

CELLS = ("First", "Second")


@pytest.fixture
def both(data: ReportData, tmp_path: Path) -> ReportData:
    write_charge(tmp_path / "other", 7200.0)
    inputs = {**data.inputs, "second_charge/peak/cc": tmp_path / "other"}
    return replace(data, inputs=inputs, cells=CELLS)


def test_only_verdicts_that_differ_are_listed():
    first = verdict_columns("holds", "contradicted", "holds")
    second = {name: column[1:] for name, column in verdict_columns("holds", "contradicted", "contradicted").items()}
    second["explanation"] = ["Same.", "Other numbers."]
    table = second_cell.statements(first, second, CELLS)
    assert table.header == ("statement", "read as", *CELLS)
    assert table.rows == (("claim <2> & more", "at 25 degC", "holds: The numbers.", "contradicted: Other numbers."),)
    said = second_cell.summary(first, second, CELLS)
    assert said == "Of the 2 statements that charges alone answer, 1 comes out differently with Second than with First."
    same = second_cell.summary(first, first, CELLS)
    assert same == "All 3 statements that charges alone answer come out the same with Second as with First."


def test_both_stand_side_by_side(both: ReportData):
    table = second_cell.side_by_side(both)
    assert table.header == ("charge", "quantity", "unit", *CELLS)
    rows = {row[:2]: row[3:] for row in table.rows}
    assert rows["Same peak current: CC-CV", "time to 95 % SOC"] == (2.5, 2.0)
    assert rows["Same peak current: CC-CV", "heat: series resistance"] == (0.5, 0.5)
    assert rows["Same mean current: CC-CV", "time to 95 % SOC"] == (2.5, None)
    assert rows["Same peak current: CV-Reflex", "heat, all paths"] == (0.5, None)


def test_its_charges_read_as_the_firsts_and_nothing_else_does(both: ReportData):
    second = both.second()
    assert set(second.inputs) == {"charge/peak/cc"}
    assert second.quantities("peak", "cc") == {"time_to_soc_0.95_s": 7200.0}


def test_the_page_has_a_section_of_its_own(content: PageContent, both: ReportData):
    figure = PageFigure("two_cells", "", "Both", "Both batteries", SVG)
    section = PageSection("second-cell", "Where <it> differs", "One.", [second_cell.side_by_side(both)], [figure])
    page = Page(render(replace(content, sections=[section])))
    order = [name for name in page.attributes("id") if not name.startswith("statement-")]
    place = order.index("second-cell")
    assert order[place : place + 4] == ["second-cell", "second_charges", "two_cells", "in-numbers"]
    assert "#second-cell" in page.attributes("href")
    assert "Where <it> differs" in page.text


@pytest.mark.parametrize(
    ("best", "searched", "said"),
    [
        (1.17, (1.0, 500.0), []),
        (1.17, None, []),
        (0.4, (1.0, 500.0), ["is least at 0.4 Hz, outside the 1 Hz to 500 Hz"]),
        (None, (1.0, 500.0), ["has no least value, outside the 1 Hz to 500 Hz"]),
    ],
)
def test_an_optimum_outside_the_range_is_told(tmp_path: Path, best, searched, said):
    columns = quantity.columns([quantity.Quantity("optimal_frequency_hz", best, "Hz", "")])
    tables.write(schemas.QUANTITIES, columns, tmp_path / "quantities.parquet")
    found = beyond_range(ReportData({"objective": tmp_path}, {}, {}), searched)
    assert len(found) == len(said)
    assert all(part in sentence for part, sentence in zip(said, found, strict=True))
