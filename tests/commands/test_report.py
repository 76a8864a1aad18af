"""What `report` says of a run: of the project's own study where none is named, in numbers where none is published."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import init, looking, report
from pipeline.config import inheritance
from pipeline.errors import UserError
from pipeline.experiments.charges.tables import CHARGE
from pipeline.kernel import places, tables

SUMMARIES: Mapping[str, Mapping[str, float]] = {
    "cc_cv": {"time_to_soc_0.5_s": 3600.0, "time_to_soc_0.9_s": 9000.0, "end_soc": 0.95, "peak_temperature_c": 31.25},
    "gentle": {"time_to_soc_0.5_s": 7200.0, "time_to_soc_0.9_s": float("nan"), "end_soc": 0.8},
}
TITLES = {"cc_cv": "CC-CV", "gentle": "Gentle at 1 A"}


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project as `init` makes it, which is worked in."""
    list(init.write(tmp_path / "own"))
    confs = (tmp_path / "own" / "conf", places.SHIPPED / "conf")
    for module in (inheritance, places):
        monkeypatch.setattr(module, "confs", lambda: confs)
    monkeypatch.chdir(tmp_path / "own")
    return tmp_path / "own"


def _publish(name: str, manifest: str = "manifest.json", **others: Any) -> None:
    """Leave a run as publishing does: the summaries of two charges, and a manifest."""
    folder = Path("results") / "own" / name
    artefacts, nodes = [], {}
    for number, (mode, summary) in enumerate(SUMMARIES.items()):
        path = folder / "charge" / "charges" / f"{mode}.summary.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = [*((key, value, None) for key, value in summary.items()), ("end_reason", None, "stop: soc 0.95")]
        quantity, value, text = zip(*rows, strict=True)
        columns = {"quantity": quantity, "value": value, "text": text}
        tables.write(CHARGE["summary"].table, columns | dict.fromkeys(("unit", "description"), [""] * len(rows)), path)
        nodes[f"charge/charges/{mode}"] = {"step": "charge", "key": str(number) * 64}
        artefacts.append({"step": "charge", "key": str(number) * 64, "file": path.name.split(".", 1)[1]})
        artefacts[-1]["path"] = path.as_posix()
    cards = {"modes": {mode: {"title": title} for mode, title in TITLES.items()}}
    told = {"study": "own", "run": name, "overrides": [], "artefacts": artefacts, "nodes": nodes} | others
    told["configuration"] = cards | {"comparisons": {"charges": {"title": "as configured"}}}
    (folder / manifest).write_text(json.dumps(told), encoding="utf-8")


def test_without_a_name_it_is_the_study_that_the_project_names(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(UserError, match=r"run 'own/default': not published here; to make it: .* study=own$"):
        report.main([])
    _publish("default")
    assert report.main([]) == 0
    assert "as configured" in capsys.readouterr().out
    # What a shell completes is of that study too.
    assert looking.completed("charge-pipeline modes.own_p") == ["modes.own_pulse."]


@pytest.mark.parametrize("named", ["own", "own/default", "results/own/default/"])
def test_a_study_without_published_statements_is_told_in_numbers(
    named: str, project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _publish("default")
    page = Path("reports") / "own" / "default" / "index.html"
    page.parent.mkdir(parents=True)
    page.write_text("")
    assert report.main([named]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines[:6] == [
        "as configured",
        "quantity unit CC-CV Gentle at 1 A",
        "Time to SOC 0.5 h 1 2",
        "Time to SOC 0.9 h 2.5 –",
        "End SOC % 95 80",
        "Peak temperature °C 31.25 –",
    ]
    assert lines[6:] == ["Ended by stop at SOC 95 % stop at SOC 95 %", "", "the page: reports/own/default/index.html"]


def test_of_a_run_that_was_made_in_part_it_says_what_to_type(project: Path) -> None:
    _publish("x=1", "manifest.search.json", overrides=["x=1", "y=[a, b]"])
    with pytest.raises(UserError, match=r"only parts of it are here \(search\); .* study=own x=1 'y=\[a, b\]'$"):
        report.main(["own/x=1"])


def test_a_run_of_a_sweep_is_made_whole_and_told(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[list[str]] = []

    def make(words: list[str]) -> int:
        asked.append(words)
        _publish("seed=2", overrides=["seed=2"])
        return 0

    monkeypatch.setattr("pipeline.commands.run.main", make)
    sweep = Path("results") / "own" / "sweeps" / "two"
    sweep.mkdir(parents=True)
    told = {"study": "own", "sweep": {"seed=2": {"overrides": ["seed=2"], "values": [2]}}}
    (sweep / "manifest.json").write_text(json.dumps(told))
    assert report.main(["seed=2"]) == 0
    assert asked == [["study=own", "seed=2"]]
    assert "Gentle at 1 A" in capsys.readouterr().out
