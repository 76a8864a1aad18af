"""The steps that judge and tell a run: on artefacts that never were, and with no experiment's pages at all."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.experiments.reporting import page, verdicts
from pipeline.quantity import Quantity
from tests import making
from tests.report_pages.test_pages import Page, main_parts

CARD = {"name": "one", "module": "pipeline.experiments.none.figures.one", "paper": "", "title": "One", "caption": "One"}
STATEMENT = {
    "name": "fast",
    "where": "page 1",
    "says": "ninety a second",
    "basis": "model",
    "check": {"close": {"value": "frequency_hz of search.quantities", "to": 90, "tolerance": 0.5}},
}


def settings(**changed: Any) -> dict[str, Any]:
    return {
        "study": {"title": "A study", "question": "What is asked?", "paper": "Author (2015).", "doi": ""},
        "battery": "A battery",
        "figures": [CARD | {"draw": "one", "options": {}}],
        "pages": [],
        "parameters": [
            {"path": "a.b_v", "value": 1.0, "unit": "V", "kind": "estimate", "ref": "x", "range": None, "to": None}
        ],
        "command": "snakemake study",
        "overrides": ["seed=1"],
        "settings": {},
        "modes": [],
        "comparisons": [],
        "captions": {},
        "not_drawn": {},
        "rests": {"fast": {"artefacts": ["search"], "file": "conf/published/a.yaml", "key": "fast"}},
        "place": "a_study/seed=1",
        "hero": "one",
        "seed": 1,
    } | changed


@pytest.fixture
def judged(tmp_path: Path) -> dict[str, Path]:
    """Return the artefacts of a run: a number, the verdict on it, a figure."""
    making.output("search", tmp_path / "search").numbers([Quantity("frequency_hz", 90.25, "Hz", "")])
    inputs = making.inputs({"search": tmp_path / "search"})
    asked = {"statements": [STATEMENT], "answer": [], "called": [], "calibrated": {}, "second_calibrated": None}
    verdicts.run(asked, inputs, making.output("verdicts", tmp_path / "verdicts"))
    (tmp_path / "figure").mkdir()
    (tmp_path / "figure" / "one.svg").write_text("<svg></svg>", encoding="utf-8")
    (tmp_path / "figure" / "one.png").write_bytes(b"\x89PNG")
    return {"verdicts": tmp_path / "verdicts", "figure/one": tmp_path / "figure"}


def test_a_statement_becomes_a_verdict(judged: dict[str, Path]) -> None:
    found = making.inputs(judged).table("verdicts", "verdicts")
    assert (found["verdict"][0], found["margin"][0]) == ("holds", 0.25)
    assert found["explanation"][0] == "Frequency: 90.25 Hz; required: 90 ± 0.5 Hz."


def test_a_page_without_any_experiment_shows_verdicts_figures_and_parameters(
    judged: dict[str, Path], tmp_path: Path
) -> None:
    page.run(settings(), making.inputs(judged), making.output("page", tmp_path / "page"))
    shown = Page((tmp_path / "page" / "index.html").read_text(encoding="utf-8"))
    assert main_parts(shown) == ["matrix", "verdicts", "figures", "one", "parameters", "parameters-a", "reproduce"]
    card = json.loads((tmp_path / "page" / "card.json").read_text(encoding="utf-8"))
    assert (card["counts"], card["departs"]) == ([["holds", 1]], ["seed=1"])
    assert card["picture"]["file"] == "figures/one.svg"
    assert not (tmp_path / "page" / "traces.js").exists()
    assert "departs from the study by seed=1" in " ".join(shown.text)
    tables = tmp_path / "page" / "tables"
    assert {path.name for path in tables.iterdir()} == {"verdicts.csv", "parameters.csv"}
    with (tables / "parameters.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["key"], row["value"], row["unit"]) == ("a.b_v", "1", "V")


def test_a_page_without_verdicts_is_still_a_page(tmp_path: Path) -> None:
    page.run(settings(figures=[]), making.inputs({}), making.output("page", tmp_path / "page"))
    assert "verdicts" not in Page((tmp_path / "page" / "index.html").read_text(encoding="utf-8")).attributes("id")
