"""The section on the second battery: its words and tables follow from the artefacts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.experiments.charges import page as charges_page
from pipeline.experiments.charges import second_cell
from pipeline.report.pages import PageContent, PageFigure, PageSection, render
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.charges.test_page import run, write_run
from tests.report_pages.conftest import content, verdict_columns
from tests.report_pages.test_pages import Page, main_parts

__all__ = ["content", "run"]

CELLS = ("First", "Second")


@pytest.fixture
def both(run: ReportData, tmp_path: Path) -> ReportData:
    write_run(tmp_path / "other", 7200.0)
    inputs = making.inputs({**run.inputs, "second_charge/peak/cc": tmp_path / "other"})
    return replace(run, inputs=inputs, settings={"cells": {"titles": CELLS}})


def test_only_statements_that_come_out_otherwise_are_listed():
    first = verdict_columns("holds", "contradicted", "holds")
    second = {name: column[1:] for name, column in verdict_columns("holds", "contradicted", "not reproduced").items()}
    second["explanation"] = ["Same.", "Other numbers."]
    table = second_cell.statements(first, second, CELLS)
    assert table.header == ("statement", "tested as", *CELLS)
    assert table.rows == (("claim <2> & more", "at 25 degC", "met: The numbers.", "not met: Other numbers."),)
    said = second_cell.summary(first, second, CELLS)
    assert said == "Of the 2 statements that charges alone answer, 1 has another outcome with Second than with First."
    same = second_cell.summary(first, first, CELLS)
    assert same == "All 3 statements that charges alone answer have the same outcome with Second as with First."


def test_both_stand_side_by_side(both: ReportData):
    table = second_cell.side_by_side(both)
    assert table.header == ("charge", "quantity", "unit", *CELLS)
    rows = {row[:2]: row[3:] for row in table.rows}
    assert rows["Same peak current: CC-CV", "time to 95 % SOC"] == (2.5, 2.0)
    assert rows["Same peak current: CC-CV", "heat: series resistance"] == (0.5, 0.5)
    assert rows["Same mean current: CC-CV", "time to 95 % SOC"] == (2.5, None)
    assert rows["Same peak current: CV-Reflex", "heat, all paths"] == (0.5, None)


def test_its_charges_read_as_the_firsts_and_nothing_else_does(both: ReportData):
    second = second_cell.second(both)
    assert set(second.inputs) == {"charge/peak/cc"}
    assert second.quantities("peak", "cc") == {"time_to_soc_0.95_s": 7200.0}


def test_the_page_has_a_section_of_its_own(content: PageContent, both: ReportData):
    figure = PageFigure("two_cells", "", "Both", "Both batteries")
    section = PageSection("second-cell", "Where <it> differs", "One.", [second_cell.side_by_side(both)], [figure])
    page = Page(render(replace(content, sections=[section])))
    order = main_parts(page)
    place = order.index("second-cell")
    assert order[place : place + 4] == ["second-cell", "two_cells", "table-second_charges", "in-numbers"]
    assert "#second-cell" in page.attributes("href")
    assert "Where <it> differs" in page.text


def test_the_section_lists_what_differs_and_the_figure_of_both(both: ReportData, tmp_path: Path):
    first = verdict_columns("holds", "contradicted")
    second = verdict_columns("holds", "holds")
    output = making.output("verdicts", tmp_path / "verdicts")
    output.write("verdicts", first)
    output.write("second", second)
    data = replace(both, inputs=making.inputs({**both.inputs, "verdicts": tmp_path / "verdicts"}))
    figures = [PageFigure(name, "", name, name, draws=name) for name in ("two_cells", "energy")]
    (section,) = charges_page.sections(data, figures)
    assert [table.name for table in section.tables] == ["second_differs", "second_charges"]
    assert [figure.name for figure in section.figures] == ["two_cells"]
    assert charges_page.sections(replace(data, settings={}), figures) == []
