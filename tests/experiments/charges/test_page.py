"""What the page tells of charges: tables of their results and energy, and sentences on goals they did not reach."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.experiments.charges import declaration, page
from pipeline.report.tables import ModeLabel, ReportData
from tests import making


def write_run(folder: Path, time_s: float | None) -> None:
    output = making.output("charge", folder)
    summary = {
        "quantity": ["time_to_soc_0.95_s", "end_reason"],
        "value": [time_s, None],
        "text": [None, "stop: elapsed 43200 s"],
        "unit": ["s", ""],
        "description": ["", ""],
    }
    output.write("summary", summary)
    energy = {
        "path": ["electrical input", "series resistance"],
        "role": ["input", "loss"],
        "energy_j": [36000.0, 1800.0],
        "description": ["", ""],
    }
    output.write("energy", energy)


@pytest.fixture
def run(tmp_path: Path) -> ReportData:
    inputs = {}
    for name, time_s in {"peak/cc": 9000.0, "peak/reflex": None, "mean/cc": 9000.0}.items():
        inputs[f"charge/{name}"] = tmp_path / name
        write_run(tmp_path / name, time_s)
    labels = {"cc": ModeLabel("CC-CV"), "reflex": ModeLabel("CV-Reflex")}
    return ReportData(making.inputs(inputs), labels, {"peak": "Same peak current", "mean": "Same mean current"})


def test_a_charge_that_did_not_get_there_or_was_not_made_leaves_its_cell_empty(run: ReportData) -> None:
    table = page.charges(run)
    assert table.header == ("comparison", "quantity", "unit", "CC-CV", "CV-Reflex")
    assert table.rows[0] == ("Same peak current", "time_to_soc_0.95_s", "s", 9000.0, None)
    assert table.rows[1][3] == "stop: elapsed 43200 s"
    assert table.rows[2] == ("Same mean current", "time_to_soc_0.95_s", "s", 9000.0, None)
    assert table.numeric() == [False, False, False, True, False]


def test_energy_is_told_in_watt_hours(run: ReportData) -> None:
    rows = page.energy(run).rows
    assert rows[:2] == (
        ("Same peak current", "electrical input", "input", 10.0, 10.0),
        ("Same peak current", "series resistance", "loss", 0.5, 0.5),
    )
    assert rows[2][3:] == (10.0, None)


def test_nothing_is_told_where_nothing_is_charged() -> None:
    data = ReportData(making.inputs({}), {}, {})
    assert (page.tables(data), page.notes(data), page.sections(data, [])) == ([], [], [])


def test_a_charge_that_missed_its_goal_is_told_in_a_sentence(tmp_path: Path) -> None:
    write_run(tmp_path / "missed", None)
    summary = {
        "quantity": ["missed"],
        "value": [None],
        "text": ["SOC 0.95 not reached, stopped by the 8 h time limit at SOC 0.18"],
        "unit": [""],
        "description": [""],
    }
    making.output("charge", tmp_path / "missed").write("summary", summary)
    making.output("charge", tmp_path / "reached").write("summary", summary | {"text": [""]})
    inputs = {"charge/peak/cc": tmp_path / "missed", "charge/peak/reflex": tmp_path / "reached"}
    labels = {"cc": ModeLabel("CC-CV"), "reflex": ModeLabel("CV-Reflex")}
    data = ReportData(making.inputs(inputs), labels, {"peak": "Same peak current"})
    assert page.notes(data) == [
        "CC-CV (Same peak current): SOC 0.95 not reached, stopped by the 8 h time limit at SOC 0.18."
    ]


def test_the_page_says_which_currents_a_comparison_scaled() -> None:
    words = ["study=solar_reflex", "battery=lead_acid_12v18ah", "modes.cc_cv.max_current_a=4.0"]
    study = study_from(compose_tree(words))
    settings = {"scaled": declaration.EXPERIMENT.labels["scaled"].make(study)}
    modes = {name: ModeLabel(study.modes[name].title) for name in study.run}
    data = ReportData(
        making.inputs({}), modes, {name: card.title for name, card in study.comparisons.items()}, settings
    )
    told = "all currents times 1.905, the largest from 2.1 A to 4 A, to match CC-CV."
    titles = [f"{title} ({comparison})" for comparison in ("same peak current", "same mean current")
              for title in ("CV-pulse", "CV-Reflex")]  # fmt: skip
    assert page.notes(data) == [f"{title}: {told}" for title in titles]
    assert declaration.EXPERIMENT.labels["scaled"].make(study_from(compose_tree(words[:1]))) == {}
