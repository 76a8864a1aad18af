"""`python -m pipeline store`: what it verifies, what it lists, what it cleans away and what it leaves."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.__main__ import main
from pipeline.commands.store import size
from pipeline.kernel import digest, planfile, receipts, store

KEYS = {name: letter * 64 for name, letter in (("old", "a"), ("young", "b"), ("planned", "c"), ("shown", "d"))}
DAY_S = 86_400


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four artefacts of 1000 bytes: two that nothing names, one that a plan names, one that is published."""
    monkeypatch.chdir(tmp_path)
    for age, (name, key) in enumerate(reversed(KEYS.items())):
        made = store.make(store.RESULTS, "step", key, lambda folder: (folder / "x.txt").write_text("x" * 1000))
        receipts.write(store.RESULTS, "step", f"{name}-1", {key: made}, {})
        folder = store.artefact(store.RESULTS, "step", key)
        then = folder.stat().st_mtime - age * DAY_S
        os.utime(folder, (then, then))
    run = {"study": "mine", "nodes": {"n": {"step": "step", "key": KEYS["planned"]}}}
    planfile.save({"version": planfile.VERSION, "runs": [run], "nodes": {}, "chunks": {}}, store.RESULTS)
    view = Path("results/mine/default")
    store.link(store.artefact(store.RESULTS, "step", KEYS["shown"]) / "x.txt", view / "x.txt")
    entry = {"path": "results/mine/default/x.txt", "sha256": digest.of_file(view / "x.txt")}
    nodes = {"n": {"step": "step", "key": KEYS["shown"]}}
    manifest = {"digest": "one", "artefacts": [entry], "nodes": nodes}
    store.write_json(view / "manifest.json", manifest)
    kept = receipts.view(manifest, [entry], whole=True)
    receipts.write(store.RESULTS, "publish", "mine-1", {}, {"results/mine/default/manifest.json": kept})
    return store.RESULTS


def _left(results: Path) -> set[str]:
    there = {path.name for path in (results / "store" / "step").iterdir()}
    return {name for name, key in KEYS.items() if key in there}


def test_what_is_whole_is_told_by_kind(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["store", "verify"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "4 artefacts whole, 0 damaged",
        "1 views whole, 0 damaged",
        "1 plans whole, 0 damaged",
        "5 receipts whole, 0 damaged",
    ]


def _write(path: Path, text: str) -> None:
    path.chmod(0o644)
    path.write_text(text)


def _swap(path: Path) -> None:
    path.unlink()
    path.write_text("junk")


FAULTS: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "a stored file": (f"store/step/{KEYS['old']}/x.txt", lambda path: _write(path, "y"), "artefacts"),
    "a file of a view": ("mine/default/x.txt", _swap, "views"),
    "a file lost from a view": ("mine/default/x.txt", Path.unlink, "views"),
    "a manifest": ("mine/default/manifest.json", lambda path: _write(path, "{"), "views"),
    "a plan": ("plan/*.json", lambda path: _write(path, "{"), "plans"),
    "an edited plan": ("plan/*.json", lambda path: _write(path, path.read_text().replace("mine", "yours")), "plans"),
    "a receipt": ("receipts/step/old-1.json", lambda path: _write(path, "[1]"), "receipts"),
    "all of an artefact": (f"store/step/{KEYS['young']}", store.remove, "receipts"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_damage_is_told_by_kind(fault: str, results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pattern, damage, kind = FAULTS[fault]
    (path,) = results.glob(pattern)
    damage(path)
    before = sorted(results.rglob("*"))
    assert main(["store", "verify"]) == 1
    told = capsys.readouterr().out
    assert f"{kind} whole, 1 damaged" in told
    assert f"damaged: {path}" in told or f"damaged: plan {path}" in told or str(path) in told
    assert sorted(results.rglob("*")) == before, "verifying moves nothing"


def test_what_is_there_is_listed_with_size_study_and_age(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["store"]) == 0
    rows = [line.split("│") for line in capsys.readouterr().out.splitlines() if line.startswith("│")]
    told = {row[2].strip(): [cell.strip() for cell in row[1:-1]] for row in rows}
    assert told["mine"][:3] == ["step", "mine", "1"]
    assert told["mine"][3].endswith("KiB")
    assert told["mine"][4] == "24 h"
    assert told["no plan"][2] == "3"
    assert told["no plan"][4] == "0 s to 3 d"


def test_what_no_published_run_names_is_cleaned_with_its_receipts(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["store", "clean"]) == 0
    assert _left(results) == {"shown"}
    assert sorted(path.name for path in results.glob("receipts/*/*.json")) == ["mine-1.json", "shown-1.json"]
    assert main(["store", "verify"]) == 0


def test_the_oldest_that_no_plan_names_go_first(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    total = sum(path.stat().st_size for path in (results / "store").rglob("*") if path.is_file())
    assert main(["store", "clean", "--keep-below", f"{total}B"]) == 0
    assert _left(results) == set(KEYS)
    assert main(["store", "clean", "--keep-below", f"{total - 1}B"]) == 0
    assert _left(results) == {"young", "planned", "shown"}
    assert "still above" not in capsys.readouterr().out
    assert main(["store", "clean", "--keep-below", "1KiB"]) == 0
    assert _left(results) == {"planned", "shown"}
    assert "still above 1 KiB" in capsys.readouterr().out


def test_temporary_files_of_ended_processes_are_cleaned(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    dead = results / "receipts" / "step" / f".old-1.json.abcdefgh.{ended.pid}"
    folder = results / "store" / "step" / f".{KEYS['old']}.abcdefgh.{ended.pid}"
    living = results / "receipts" / "step" / f".old-1.json.abcdefgh.{os.getpid()}"
    (folder / "part").mkdir(parents=True)
    for path in (dead, living, folder / "part" / "half"):
        path.write_text("half")
    assert main(["store", "clean"]) == 0
    assert "2 temporary files of ended processes removed" in capsys.readouterr().out
    assert not dead.exists()
    assert not folder.exists()
    assert living.exists()


@pytest.mark.parametrize("word", [["clean"], ["clean", "--keep-below", "1KiB"]])
def test_nothing_is_cleaned_while_a_manifest_cannot_be_read(
    word: list[str], results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (results / "mine/default/manifest.json").write_text("{")
    assert main(["store", *word]) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: results/mine/default/manifest.json: not a manifest")
    assert told.count("\n") == 1
    assert _left(results) == set(KEYS)


def test_nothing_is_dropped_while_a_plan_cannot_be_read(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (plan,) = results.glob("plan/*.json")
    plan.write_text(json.dumps({}))
    assert main(["store", "clean", "--keep-below", "0B"]) == 2
    assert _left(results) == set(KEYS)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("2GiB", 2**31), ("500 MiB", 500 * 2**20), ("1.5kB", 1500), ("0", 0), ("7b", 7), ("1e6", 10**6)],
)
def test_sizes(text: str, expected: int) -> None:
    assert size(text) == expected


@pytest.mark.parametrize("text", ["", "GiB", "2 apples", "-1GiB", "1..2", "nan"])
def test_no_sizes(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is no size"):
        size(text)
