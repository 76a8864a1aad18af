"""Receipts tell the truth, or go."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from pipeline.kernel import receipts, store

KEY = "a" * 64
ONE: Mapping[str, Mapping[str, Any]] = {"one-1": {"step": "step", "needs": []}}


def _writer(text: str) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "one.txt").write_text(text)
        (folder / "part").mkdir()
        (folder / "part" / "two.txt").write_text(text * 2)

    return write


def test_broken_receipts_are_dropped(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    names = ("good-1", "gone-1", "torn-1")
    chunks = {name: {"step": "step", "needs": []} for name in names} | {
        "after-1": {"step": "step", "needs": ["gone-1"]}
    }
    receipts.write(tmp_path, "step", "after-1", {KEY: made}, {})
    receipts.write(tmp_path, "step", "good-1", {KEY: made}, {})
    receipts.write(tmp_path, "step", "gone-1", {"b" * 64: made}, {})
    receipts.path_of(tmp_path, "step", "torn-1").write_text('{"step": "st')
    assert sorted(receipts.drop_broken(tmp_path, chunks)) == ["after-1", "gone-1", "torn-1"]
    assert receipts.path_of(tmp_path, "step", "good-1").is_file()


def test_behind_a_receipt_that_cannot_be_read_damage_is_said_too(tmp_path: Path) -> None:
    keys = [letter * 64 for letter in "abc"]
    for key in keys:
        store.make(tmp_path, "step", key, _writer(key[0]))
    store.remove(store.artefact(tmp_path, "step", keys[0]))
    damaged = store.artefact(tmp_path, "step", keys[1])
    (damaged / "one.txt").chmod(0o644)
    (damaged / "one.txt").write_text("y")
    chunks = {"torn-1": {"step": "step", "nodes": keys, "needs": []}}
    path = receipts.path_of(tmp_path, "step", "torn-1")
    store.write_text(path, "")
    looked, said = [], []
    assert receipts.drop_broken(tmp_path, chunks, say=looked.append, look=True) == ["torn-1"]
    assert damaged.is_dir()
    assert receipts.drop_broken(tmp_path, chunks, say=said.append) == ["torn-1"]
    assert said[0] == f"{path} cannot be read: written anew"
    assert said[1].endswith(f"{keys[0]} is missing: made again")
    assert f"{damaged / 'one.txt'} changed since it was sealed: made again" in said[2]
    assert len(said) == len(looked) == 3
    assert [*(tmp_path / "quarantine").rglob("one.txt")] != []
    assert not damaged.exists()


VIEW = {"p-1": {"step": "publish", "needs": []}}


def _publish(results: Path, run: str = "one", **more: Any) -> Path:
    """Put a file into a view, with a manifest and a receipt."""
    folder = results / "study" / "run"
    (folder / "part").mkdir(parents=True, exist_ok=True)
    (folder / "part" / "x.txt").write_text("x")
    entry = {"path": "results/study/run/part/x.txt", "sha256": receipts.digest.of_file(folder / "part" / "x.txt")}
    manifest = {"digest": run, "artefacts": [entry], "commit": None, **more}
    store.write_json(folder / "manifest.json", manifest)
    view = receipts.view(manifest, manifest["artefacts"], whole=True)
    receipts.write(results, "publish", "p-1", {}, {"results/study/run/manifest.json": view})
    return folder / "manifest.json"


def test_a_receipt_of_a_view_ends_with_the_view(tmp_path: Path) -> None:
    results = tmp_path / "results"
    manifest = _publish(results)
    assert receipts.drop_broken(results, VIEW) == []
    store.write_json(manifest, json.loads(manifest.read_text()) | {"digest": "two"})
    said: list[str] = []
    assert receipts.drop_broken(results, VIEW, say=said.append) == ["p-1"]
    assert said == [], "another run was published, nothing is damaged"


def test_another_commit_is_no_damage(tmp_path: Path) -> None:
    results = tmp_path / "results"
    manifest = _publish(results)
    store.write_json(manifest, json.loads(manifest.read_text()) | {"commit": "abc"})
    assert receipts.drop_broken(results, VIEW) == []


@pytest.mark.parametrize("text", ["{", "", "[1]", '{"digest": "one", "artefacts": []}', "[" * 100_000])
def test_a_damaged_manifest_is_quarantined_and_said(text: str, tmp_path: Path) -> None:
    results = tmp_path / "results"
    manifest = _publish(results)
    manifest.write_text(text)
    said: list[str] = []
    assert receipts.drop_broken(results, VIEW, say=said.append) == ["p-1"]
    assert len(said) == 1
    assert said[0].startswith(f"{manifest} ")
    assert said[0].endswith("written anew")
    assert not manifest.exists()
    assert [path.name for path in results.glob("quarantine/*/*/*")] == ["manifest.json"]
    assert list(results.glob("*/*/manifest*.json")) == [], "nobody who looks for runs finds it"


@pytest.mark.parametrize("replaced", ["junk", "gone", "folder"])
def test_a_damaged_file_of_a_view_is_quarantined_and_said(replaced: str, tmp_path: Path) -> None:
    results = tmp_path / "results"
    file = _publish(results).parent / "part" / "x.txt"
    file.unlink()
    if replaced == "junk":
        file.write_text("junk")
    elif replaced == "folder":
        file.mkdir()
    said: list[str] = []
    assert receipts.drop_broken(results, VIEW, say=said.append) == ["p-1"]
    assert len(said) == 1
    assert str(file) in said[0]
    assert not file.exists()


def test_a_receipt_that_points_elsewhere_moves_nothing(tmp_path: Path) -> None:
    results = tmp_path / "results"
    _publish(results)
    outside = tmp_path / "outside.txt"
    outside.write_text("mine")
    path = receipts.path_of(results, "publish", "p-1")
    made = json.loads(path.read_text())
    made["views"]["results/study/run/manifest.json"]["shown"] = {"results/../outside.txt": "0"}
    path.write_text(json.dumps(made))
    assert receipts.drop_broken(results, VIEW, True) == ["p-1"]
    assert outside.read_text() == "mine"


@pytest.mark.parametrize("text", ["garbage", "", "[]", "{}", '{"one.txt": 3}'])
def test_a_damaged_list_of_contents_is_quarantined_and_said(text: str, tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    receipts.write(tmp_path, "step", "one-1", {KEY: made}, {})
    contents = store.artefact(tmp_path, "step", KEY) / store.CONTENTS
    contents.chmod(0o644)
    contents.write_text(text)
    said: list[str] = []
    assert receipts.drop_broken(tmp_path, ONE, say=said.append) == ["one-1"]
    assert len(said) == 1
    assert str(contents) in said[0]
    assert store.make(tmp_path, "step", KEY, _writer("x")) == made


def test_looking_changes_nothing(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    receipts.write(tmp_path, "step", "one-1", {KEY: made}, {})
    victim = store.artefact(tmp_path, "step", KEY) / "one.txt"
    victim.chmod(0o644)
    victim.write_text("y")
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    assert receipts.drop_broken(tmp_path, ONE, look=True) == ["one-1"]
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before


def test_receipts_are_dated_in_the_order_of_the_plan_and_not_ahead(tmp_path: Path) -> None:
    names = ("one-1", "two-2", "three-3")
    chunks = {"one-1": {"step": "step", "needs": []}, "two-2": {"step": "step", "needs": ["one-1"]}}
    chunks["three-3"] = {"step": "step", "needs": ["two-2"]}
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    ahead = time.time_ns() + 10**18
    for name, dated in zip(names, (ahead, 10**18, ahead + 10**9), strict=True):
        receipts.write(tmp_path, "step", name, {KEY: made}, {})
        os.utime(receipts.path_of(tmp_path, "step", name), ns=(dated, dated))
    said: list[str] = []
    assert receipts.drop_broken(tmp_path, chunks, say=said.append) == []
    times = [receipts.path_of(tmp_path, "step", name).stat().st_mtime_ns for name in names]
    assert times == sorted(times)
    assert times[-1] <= time.time_ns()
    assert len([line for line in said if "ahead of the clock" in line]) == 2


def test_a_folder_where_a_receipt_belongs_is_moved_away(tmp_path: Path) -> None:
    path = receipts.path_of(tmp_path, "step", "one-1")
    (path / "deep").mkdir(parents=True)
    assert receipts.drop_broken(tmp_path, ONE) == ["one-1"]
    assert not path.exists()


@pytest.mark.parametrize("verify", [False, True])
def test_what_changed_at_rest_is_quarantined_and_said(verify: bool, tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    receipts.write(tmp_path, "step", "one-1", {KEY: made}, {})
    chunks = ONE
    victim = store.artefact(tmp_path, "step", KEY) / "one.txt"
    before = victim.stat()
    victim.chmod(0o644)
    victim.write_text("y")
    said: list[str] = []
    if verify:
        # Same size, time and inode: only reading shows it.
        os.utime(victim, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert receipts.drop_broken(tmp_path, chunks, say=said.append) == []
    assert receipts.drop_broken(tmp_path, chunks, verify, said.append) == ["one-1"]
    assert len(said) == 1
    assert str(victim) in said[0]
    assert [path.read_text() for path in (tmp_path / "quarantine").rglob("*.txt")] == ["y"]
    assert store.make(tmp_path, "step", KEY, _writer("x")) == made


def test_a_touched_file_of_the_same_content_stays(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    receipts.write(tmp_path, "step", "one-1", {KEY: made}, {})
    receipt = receipts.path_of(tmp_path, "step", "one-1")
    before = receipt.stat().st_mtime_ns
    os.utime(store.artefact(tmp_path, "step", KEY) / "one.txt", ns=(1, 1))
    assert receipts.drop_broken(tmp_path, ONE) == []
    assert receipt.stat().st_mtime_ns == before


@pytest.mark.parametrize("text", ["[1]", "{", "3", ""])
def test_a_damaged_receipt_is_dropped(text: str, tmp_path: Path) -> None:
    store.write_text(receipts.path_of(tmp_path, "step", "one-1"), text)
    assert receipts.drop_broken(tmp_path, ONE) == ["one-1"]
