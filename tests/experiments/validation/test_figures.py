"""Figures and sections of the checks of the engine, from made-up artefacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.experiments.validation import page
from pipeline.experiments.validation.registry import CHECKS
from pipeline.report.pages import PageFigure
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.drawing import cards, looked_at, saved

ROWS = {
    "exact": [("error", 1e-10, "at most", 1e-9, "holds"), ("other", 2e-9, "at most", 1e-9, "broken")],
    "order": [("order", 4.8, "at least", 4.5, "holds"), ("power", 1.4, None, None, "told")],
    "first_law": [
        ("lead, cc_cv, edge", 1e-12, "at most", 1e-9, "holds"),
        ("lead, cc_cv, averaged", 2e-6, "at most", 1e-6, "broken"),
        ("mistake: lead, pair lost", 1e-2, "at least", 1e-6, "holds"),
        ("mistake: lead, heat lost", 1e-9, "at least", 1e-6, "broken"),
    ],
    "against_pybamm": [("CC: voltage", 1e-9, "at most", 1e-6, "holds")],
    "against_ngspice": [("CC: voltage", None, "at most", 1e-6, "not installed")],
    "panel_checks": [("maximum power", 1e-11, "at most", 1e-6, "holds")],
}


@pytest.fixture
def data(tmp_path: Path) -> ReportData:
    inputs = {}
    for name, rows in ROWS.items():
        output = making.output("validation", tmp_path / name)
        quantity, value, relation, bound, finding = (list(part) for part in zip(*rows, strict=True))
        columns = {
            "quantity": quantity, "value": value, "unit": ["1"] * len(rows), "relation": relation, "bound": bound,
            "finding": finding, "note": [""] * len(rows),
        }  # fmt: skip
        output.write("rows", columns)
        lines = 0 if name == "against_ngspice" else 2
        points = np.logspace(-3, 0, 20)
        curves = {
            "group": ["length"] * 20 * lines, "series": ["edge"] * 20 * (lines // 2) + ["averaged"] * 20 * (lines // 2),
            "across": ["time [s]"] * 20 * lines, "up": ["error [V]"] * 20 * lines,
            "x": np.tile(points, lines), "y": np.tile(1e-3 * points**5, lines),
        }  # fmt: skip
        output.write("curves", curves)
        inputs[f"validation/{name}"] = tmp_path / name
    return ReportData(making.inputs(inputs), {}, {})


@pytest.mark.parametrize("name", sorted(cards("validation")))
def test_a_figure_is_drawn_also_where_nothing_was_compared(name: str, data: ReportData, tmp_path: Path) -> None:
    paths = saved(cards("validation")[name], data, tmp_path)
    text = paths[0].read_text()
    assert paths[1].stat().st_size > 2000
    assert looked_at(cards("validation")[name], data) == []
    assert ("is not installed on this machine" in text) == (name == "against_ngspice")


def test_sections_tell_what_is_broken_and_what_was_not_compared(data: ReportData) -> None:
    shown = PageFigure("exact_solutions", "", "t", "c", options={"check": "exact"})
    overview, *sections = page.sections(data, [shown])
    assert overview.text == "6 bounds hold, 3 are broken; not installed here, so not compared: Against ngspice."
    assert [section.name for section in sections] == list(ROWS) == list(CHECKS)
    exact = overview.tables[0].rows[0]
    assert exact == ("Exact solutions", 1, 1, 0, 0, pytest.approx(2.0), "other")
    # The nearer to its bound, the larger: 4.5 of 4.8.
    assert overview.tables[0].rows[1][5] == pytest.approx(4.5 / 4.8)
    assert overview.tables[0].rows[4] == ("Against ngspice", 0, 0, 1, 0, None, None)
    assert [list(section.figures) for section in sections] == [[shown], [], [], [], [], []]


def test_residuals_stand_battery_by_battery(data: ReportData) -> None:
    law = page.sections(data, [])[3]
    grid, mistakes = law.tables
    assert grid.rows == (("lead", "cc_cv", 1e-12, 2e-6, "broken"),)
    assert [row[-1] for row in mistakes.rows] == ["caught", "missed"]


def test_another_run_has_no_such_section() -> None:
    assert page.sections(ReportData(making.inputs({}), {}, {}), []) == []
