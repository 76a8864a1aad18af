"""The store holds whole artefacts or none."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.kernel import planfile, store
from pipeline.kernel.store import StoreError

KEY = "a" * 64


def _writer(text: str) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        (folder / "one.txt").write_text(text)
        (folder / "part").mkdir()
        (folder / "part" / "two.txt").write_text(text * 2)

    return write


def test_an_artefact_is_sealed_and_read_only(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    folder = store.artefact(tmp_path, "step", KEY)
    assert sorted(made) == ["one.txt", "part/two.txt"]
    assert store.damage(folder) is None
    assert stat.S_IMODE((folder / "one.txt").stat().st_mode) == 0o444


def test_what_is_there_is_not_made_again(tmp_path: Path) -> None:
    first = store.make(tmp_path, "step", KEY, _writer("x"))

    def never(folder: Path) -> None:
        raise AssertionError("computed although it is there")

    assert store.make(tmp_path, "step", KEY, never) == first


@pytest.mark.parametrize("fault", ["changed", "missing", "unsealed"])
def test_damage_is_seen_and_mended(fault: str, tmp_path: Path) -> None:
    store.make(tmp_path, "step", KEY, _writer("x"))
    folder = store.artefact(tmp_path, "step", KEY)
    victim = folder / ("contents.json" if fault == "unsealed" else "one.txt")
    victim.chmod(0o644)
    victim.write_text("y") if fault == "changed" else victim.unlink()
    assert store.damage(folder) is not None
    store.make(tmp_path, "step", KEY, _writer("x"))
    assert store.damage(folder) is None


def test_computing_again_compares(tmp_path: Path) -> None:
    store.make(tmp_path, "step", KEY, _writer("x"))
    store.make(tmp_path, "step", KEY, _writer("x"), again=True)
    with pytest.raises(StoreError, match=r"one\.txt"):
        store.make(tmp_path, "step", KEY, _writer("y"), again=True)
    assert (store.artefact(tmp_path, "step", KEY) / "one.txt").read_text() == "x"


def test_a_failing_step_leaves_nothing(tmp_path: Path) -> None:
    def fail(folder: Path) -> None:
        (folder / "half.txt").write_text("half")
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        store.make(tmp_path, "step", KEY, fail)
    assert list((tmp_path / "store" / "step").iterdir()) == []


def test_an_empty_artefact_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="nothing"):
        store.make(tmp_path, "step", KEY, lambda folder: None)


KILLED = """
import sys, time
from pathlib import Path
from pipeline.kernel import store

def write(folder):
    (folder / "one.txt").write_text("half")
    print("writing", flush=True)
    time.sleep(60)

store.make(Path(sys.argv[1]), "step", "a" * 64, write)
"""


def test_a_killed_job_leaves_nothing_that_counts(tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(Path(store.__file__).parents[1])}
    job = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path)], stdout=subprocess.PIPE, text=True, env=environment
    )
    assert job.stdout is not None
    assert job.stdout.readline() == "writing\n"
    job.kill()
    job.wait()
    job.stdout.close()
    assert store.damage(store.artefact(tmp_path, "step", KEY)) is not None
    store.make(tmp_path, "step", KEY, _writer("x"))
    assert [path.name for path in (tmp_path / "store" / "step").iterdir()] == [KEY]


def test_broken_receipts_are_dropped(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    names = ("good-1", "gone-1", "torn-1")
    chunks = {name: {"step": "step", "needs": []} for name in names} | {
        "after-1": {"step": "step", "needs": ["gone-1"]}
    }
    store.write_receipt(tmp_path, "step", "after-1", {KEY: made}, {})
    store.write_receipt(tmp_path, "step", "good-1", {KEY: made}, {})
    store.write_receipt(tmp_path, "step", "gone-1", {"b" * 64: made}, {})
    store.receipt(tmp_path, "step", "torn-1").write_text('{"step": "st')
    assert sorted(store.drop_broken_receipts(tmp_path, chunks)) == ["after-1", "gone-1", "torn-1"]
    assert store.receipt(tmp_path, "step", "good-1").is_file()


def test_a_receipt_of_a_view_ends_with_the_view(tmp_path: Path) -> None:
    manifest = tmp_path / "results" / "study" / "run" / "manifest.json"
    chunks = {"p-1": {"step": "publish", "needs": []}}
    store.write_json(manifest, {"digest": "one", "artefacts": []})
    store.write_receipt(tmp_path, "publish", "p-1", {}, {str(manifest): "one"})
    assert store.drop_broken_receipts(tmp_path, chunks) == []
    store.write_json(manifest, {"digest": "two", "artefacts": []})
    assert store.drop_broken_receipts(tmp_path, chunks) == ["p-1"]


def test_links_replace_and_leave_no_second_name(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).write_text(name)
    target = tmp_path / "view" / "x"
    for name in ("a", "a", "b"):
        store.link(tmp_path / name, target)
        assert target.read_text() == name
    assert [path.name for path in target.parent.iterdir()] == ["x"]


def test_texts_are_written_whole(tmp_path: Path) -> None:
    store.write_json(tmp_path / "deep" / "x.json", {"b": 1, "a": [1.5]})
    assert json.loads((tmp_path / "deep" / "x.json").read_text()) == {"a": [1.5], "b": 1}
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["x.json"]


@pytest.mark.parametrize("verify", [False, True])
def test_what_changed_at_rest_is_quarantined_and_said(verify: bool, tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    store.write_receipt(tmp_path, "step", "one-1", {KEY: made}, {})
    chunks = {"one-1": {"step": "step", "needs": []}}
    victim = store.artefact(tmp_path, "step", KEY) / "one.txt"
    before = victim.stat()
    victim.chmod(0o644)
    victim.write_text("y")
    said: list[str] = []
    if verify:
        # Same size, time and inode: only reading shows it.
        os.utime(victim, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert store.drop_broken_receipts(tmp_path, chunks, say=said.append) == []
    assert store.drop_broken_receipts(tmp_path, chunks, verify, said.append) == ["one-1"]
    assert len(said) == 1
    assert str(victim) in said[0]
    assert [path.read_text() for path in (tmp_path / "quarantine").rglob("*.txt")] == ["y"]
    assert store.make(tmp_path, "step", KEY, _writer("x")) == made


def test_a_touched_file_of_the_same_content_stays(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    store.write_receipt(tmp_path, "step", "one-1", {KEY: made}, {})
    receipt = store.receipt(tmp_path, "step", "one-1")
    before = receipt.stat().st_mtime_ns
    os.utime(store.artefact(tmp_path, "step", KEY) / "one.txt", ns=(1, 1))
    assert store.drop_broken_receipts(tmp_path, {"one-1": {"step": "step", "needs": []}}) == []
    assert receipt.stat().st_mtime_ns == before


@pytest.mark.parametrize("text", ["[1]", "{", "3", ""])
def test_a_damaged_receipt_is_dropped(text: str, tmp_path: Path) -> None:
    store.write_text(store.receipt(tmp_path, "step", "one-1"), text)
    assert store.drop_broken_receipts(tmp_path, {"one-1": {"step": "step", "needs": []}}) == ["one-1"]


def test_a_plan_that_was_cut_short_is_written_anew(tmp_path: Path) -> None:
    plan = {"version": planfile.VERSION, "runs": [], "nodes": {}, "chunks": {}}
    path = planfile.save(plan, tmp_path)
    path.write_text("{")
    assert planfile.load(planfile.save(plan, tmp_path)) == plan
