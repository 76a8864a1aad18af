"""Parts of a run: what can be asked for, what is told of it, and the commands that read what it left."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import compare, report
from pipeline.commands.workflow import Workflow, tell
from pipeline.config.planning import make_plan
from pipeline.errors import UserError
from pipeline.kernel import planfile, store, tables
from tests.making import declared

NICKEL = "study=nicd_grnn"


@pytest.fixture(scope="module")
def plan() -> dict[str, Any]:
    return make_plan([[], [NICKEL]])


def test_a_part_that_the_study_does_without_is_refused_with_those_it_has(plan: dict[str, Any]) -> None:
    alone = make_plan([[NICKEL]])
    with pytest.raises(UserError, match=r"target 'day': nicd_grnn has no such part; it has: all, network, .*charges"):
        planfile.target(alone, "day")
    assert planfile.target(plan, "day") == plan["targets"]["day"]


def test_the_name_of_a_study_is_told_from_a_part(plan: dict[str, Any]) -> None:
    with pytest.raises(UserError, match=r"not planned, solar_reflex, nicd_grnn is; .* study=lfp_cuckoo"):
        planfile.target(plan, "lfp_cuckoo")
    assert planfile.target(plan, "nicd_grnn") == plan["targets"]["nicd_grnn"]


def test_snakemake_refuses_it_too(plan: dict[str, Any], tmp_path: Path) -> None:
    file = planfile.save(plan, tmp_path)
    with pytest.raises(UserError, match="target 'staging': solar_reflex, nicd_grnn has no such part"):
        Workflow({"plan": file}, tmp_path, asked=["snakemake", "staging"])
    Workflow({"plan": file}, tmp_path, asked=["snakemake", "panel"])


def missed(plan: dict[str, Any], number: int, results: Path) -> str:
    """Write a charge that missed nothing and one that did into a run; return the line that tells of the second."""
    run = plan["runs"][number]
    charges = [(name, node) for name, node in run["nodes"].items() if node["step"] == "charge"]
    for (_, node), text in ((charges[0], ""), (charges[-1], "full")):
        folder = store.artefact(results, "charge", node["key"])
        folder.mkdir(parents=True)
        row = {"quantity": ["missed"], "value": [None], "text": [text], "unit": [""], "description": [""]}
        tables.write(declared("charge")["summary"].table, row, folder / "summary.parquet")
    return f"{run['study']}/default {charges[-1][0]}: full"


def test_only_what_was_asked_for_is_told(plan: dict[str, Any], tmp_path: Path) -> None:
    results = tmp_path / "results"
    solar, nickel = (missed(plan, number, results) for number in (0, 1))
    places = {study: f"results: {results / study / 'default'}" for study in ("solar_reflex", "nicd_grnn")}
    pages = {study: f"the page: {tmp_path / 'reports' / study / 'default' / 'index.html'}" for study in places}
    assert list(tell(plan, ["nicd_grnn"], results)) == [nickel, places["nicd_grnn"], pages["nicd_grnn"]]
    assert list(tell(plan, ["panel"], results)) == [places["solar_reflex"]]
    assert list(tell(plan, ["charges"], results)) == [solar, nickel, *places.values()]
    assert set(tell(plan, ["all"], results)) == {solar, nickel, *places.values(), *pages.values()}


def test_the_end_is_told_once(plan: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = planfile.save(plan, tmp_path / "results")
    for config, lines in (({}, 4), ({"tell": False}, 0), ({"tell": "false"}, 0)):
        Workflow({"plan": file, **config}, tmp_path / "results").tell()
        assert len(capsys.readouterr().out.splitlines()) == lines


def published(folder: Path, part: str, **artefacts: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    shown = [{"path": f"results/s/r/{name}", "sha256": content} for name, content in artefacts.items()]
    manifest = {"study": "s", "run": "r", "artefacts": shown, "command": "snakemake --cores 2 s"}
    (folder / f"manifest{part}.json").write_text(json.dumps(manifest))


def test_parts_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    published(tmp_path / "a/s/r", ".charges", trace="1")
    published(tmp_path / "a/s/r", ".panel", curves="2")
    published(tmp_path / "b/s/r", "", trace="1", curves="3")
    assert compare.main(["--trust-manifest", str(tmp_path / "a/s/r"), str(tmp_path / "b/s/r")]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "differs   results/curves",
        "          sha256 in the manifests differ",
        "1 artefacts equal, 1 differ, 0 on one side only",
        "manifests only (--trust-manifest): no artefact was read",
    ]
    published(tmp_path / "b/s/r", "", trace="1", curves="2")
    assert compare.main(["--trust-manifest", str(tmp_path / "a"), str(tmp_path / "b")]) == 0


def test_a_report_on_parts_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    published(tmp_path / "results/s/r", ".charges", trace="1")
    told = r"run 's/r': only parts of it are here \(charges\); to make all of it: python -m pipeline study=s$"
    for name in ("s/r", "results/s/r/"):
        with pytest.raises(UserError, match=told):
            report.main([name])
    with pytest.raises(UserError, match="run 's/default': not published here"):
        report.main(["s"])
