"""How far a sweep is, and which of its runs a person means."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import progress, report
from pipeline.errors import UserError
from pipeline.kernel import receipts

KEYS = [letter * 64 for letter in "abcde"]


def _plan() -> dict[str, Any]:
    """Return two runs with a node of their own each and one in common; two jobs."""
    nodes = {
        "one/charge/x": {"step": "charge", "key": KEYS[0]},
        "one/charge/y": {"step": "charge", "key": KEYS[1]},
        "two/charge/x": {"step": "charge", "key": KEYS[0]},
        "two/charge/y": {"step": "charge", "key": KEYS[2]},
        "sweep": {"step": "sweep", "key": KEYS[3]},
    }
    return {
        "runs": [{"sweep": {"one": {}, "two": {}}, "nodes": nodes}],
        "nodes": {key: {} for key in KEYS[:4]},
        "chunks": {
            "first": {"step": "charge", "nodes": KEYS[:2]},
            "second": {"step": "charge", "nodes": KEYS[2:3]},
            "last": {"step": "sweep", "nodes": KEYS[3:4]},
            "shown": {"step": "publish"},
        },
    }


def _log(results: Path, chunk: str, text: str) -> None:
    path = results / "logs" / "charge" / f"{chunk}.log"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def test_runs_are_done_when_all_their_artefacts_are(tmp_path: Path) -> None:
    made = progress.Made(_plan(), tmp_path)
    assert (made.runs, made.nodes, made.done) == (2, 4, (0, 0))
    _log(tmp_path, "first", f"charge first 1/2: {KEYS[0][:12]} in 0.1 s\ncharge first 2/2: {KEYS[1][:12]}")
    made.look()
    assert made.done == (0, 1)  # half a line counts for nothing
    _log(tmp_path, "first", f"charge first 1/2: {KEYS[0][:12]} in 0.1 s\ncharge first 2/2: {KEYS[1][:12]} in 0.1 s\n")
    made.look()
    assert made.done == (1, 2)
    _log(tmp_path, "second", f"charge second 1/1: {KEYS[2][:12]} in 0.1 s\n")
    made.look()
    made.look()
    assert made.done == (2, 3)


def test_what_has_a_receipt_is_made_before_anything_runs(tmp_path: Path) -> None:
    receipts.write(tmp_path, "charge", "first", {}, {})
    assert progress.Made(_plan(), tmp_path).done == (1, 2)


def _sweep(results: Path, name: str, battery: str) -> None:
    folder = results / "solar_reflex" / "sweeps" / name
    folder.mkdir(parents=True)
    sweep = {"battery=a": {"overrides": [f"battery={battery}"], "values": ["a"]}}
    (folder / "manifest.json").write_text(json.dumps({"study": "solar_reflex", "sweep": sweep}))


def test_a_run_of_a_sweep_is_found_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "RESULTS", tmp_path)
    assert report._of_sweep("battery=a") is None
    _sweep(tmp_path, "first", "a")
    assert report._of_sweep("battery=a") == ("solar_reflex", ["battery=a"])
    assert report._of_sweep("solar_reflex/sweeps/first/battery=a") == ("solar_reflex", ["battery=a"])
    _sweep(tmp_path, "second", "b")
    with pytest.raises(UserError, match="several sweeps have one of this name: solar_reflex/sweeps/first/battery=a"):
        report._of_sweep("battery=a")
    assert report._of_sweep("solar_reflex/sweeps/second/battery=a") == ("solar_reflex", ["battery=b"])
