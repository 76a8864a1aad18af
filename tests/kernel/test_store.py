"""The store holds whole artefacts or none."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from pipeline.kernel import planfile, store
from pipeline.kernel.errors import UserError
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


PLAN = {"version": planfile.VERSION, "runs": [], "nodes": {}, "chunks": {}}


@pytest.mark.parametrize("text", ["{", "", "[]", '{"version": 3}'])
def test_a_plan_that_was_cut_short_is_written_anew(text: str, tmp_path: Path) -> None:
    path = planfile.save(PLAN, tmp_path)
    path.write_text(text)
    with pytest.raises(UserError, match="make it anew"):
        planfile.load(path)
    said: list[str] = []
    assert planfile.load(planfile.save(PLAN, tmp_path, said.append)) == PLAN
    assert said == [f"plan {path}: changed since it was made; made anew"]


def test_an_edited_plan_is_refused_under_any_name(tmp_path: Path) -> None:
    path = planfile.save(PLAN, tmp_path)
    edited = json.loads(path.read_text()) | {"runs": [1]}
    for place in (path, tmp_path / "mine.json"):
        place.write_text(json.dumps(edited))
        with pytest.raises(UserError, match="changed since it was made; remove it and make it anew"):
            planfile.load(place)


def test_a_plan_under_the_name_of_another_is_refused(tmp_path: Path) -> None:
    path = planfile.save(PLAN, tmp_path)
    other = path.with_name("0123456789abcdef.json")
    other.write_bytes(path.read_bytes())
    with pytest.raises(UserError, match="changed since it was made"):
        planfile.load(other)


def test_a_link_on_the_way_is_refused(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    results = tmp_path / "results"
    (results / "plan").parent.mkdir()
    (results / "plan").symlink_to(elsewhere)
    with pytest.raises(UserError, match=r"a symbolic link .*remove the link"):
        planfile.save(PLAN, results)
    assert list(elsewhere.iterdir()) == []


def test_the_whole_of_results_may_be_a_link(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "results").symlink_to(tmp_path / "elsewhere")
    assert planfile.load(planfile.save(PLAN, tmp_path / "results")) == PLAN


def test_what_a_job_finds_damaged_is_made_again_by_the_next_run(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _writer("x"))
    victim = store.artefact(tmp_path, "step", KEY) / "one.txt"
    victim.chmod(0o644)
    victim.write_text("y")
    with pytest.raises(StoreError, match="run the same command again"):
        store.whole(tmp_path, "step", KEY, "input x")
    assert store.make(tmp_path, "step", KEY, _writer("x")) == made
    assert [path.read_text() for path in (tmp_path / "quarantine").rglob("one.txt")] == ["y"]


def test_a_file_where_an_artefact_belongs_is_replaced(tmp_path: Path) -> None:
    folder = store.artefact(tmp_path, "step", KEY)
    folder.parent.mkdir(parents=True)
    folder.write_text("")
    store.make(tmp_path, "step", KEY, _writer("x"))
    assert store.damage(folder) is None


def test_a_removed_artefact_leaves_what_its_links_point_to(tmp_path: Path) -> None:
    outside = tmp_path / "outside.txt"
    outside.write_text("kept")
    outside.chmod(0o600)
    folder = tmp_path / "artefact"
    folder.mkdir()
    (folder / "link").symlink_to(outside)
    store.remove(folder)
    assert outside.read_text() == "kept"
    assert stat.S_IMODE(outside.stat().st_mode) == 0o600


def test_only_what_no_living_process_owns_is_abandoned(tmp_path: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    results = tmp_path / "results"
    dead = [f"store/step/.{KEY}.abcdefgh.{ended.pid}", f"receipts/step/.one-1.json.x_3.{ended.pid}"]
    dead += ["receipts/step/.one-1.json.abcd_f12", f"study/run/.a.parquet.{ended.pid}"]
    living = [f"store/step/.{KEY}.abcdefgh.{os.getpid()}", "study/run/a.parquet", ".lock", "study/run/.gitignore"]
    for name in (*dead, *living):
        (results / name).mkdir(parents=True)
    figure = tmp_path / "reports" / "study" / "run" / f".figure.svg.{ended.pid}"
    figure.mkdir(parents=True)
    assert set(store.abandoned(results)) == {*(results / name for name in dead), figure}


def test_many_are_made_at_once_and_only_those_that_are_missing(tmp_path: Path) -> None:
    asked: list[list[str]] = []

    def write(folders: Mapping[str, Path]) -> None:
        asked.append(list(folders))
        for key, folder in folders.items():
            (folder / "a.txt").write_text(key)

    first = store.make_many(tmp_path, "step", ["k1", "k2"], write)
    both = store.make_many(tmp_path, "step", ["k1", "k2", "k3"], write)
    assert asked == [["k1", "k2"], ["k3"]]
    assert {key: both[key] for key in first} == first
    for key in ("k1", "k2", "k3"):
        assert store.damage(store.artefact(tmp_path, "step", key)) is None
        assert (store.artefact(tmp_path, "step", key) / "a.txt").stat().st_mode & 0o777 == 0o444


def test_of_many_that_fail_none_is_left(tmp_path: Path) -> None:
    def write(folders: Mapping[str, Path]) -> None:
        (folders["k1"] / "a.txt").write_text("whole")
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError, match="no more"):
        store.make_many(tmp_path, "step", ["k1", "k2"], write)
    assert list((tmp_path / "store" / "step").iterdir()) == []


def test_one_of_many_that_comes_out_different_is_told(tmp_path: Path) -> None:
    def write(folders: Mapping[str, Path]) -> None:
        for folder in folders.values():
            (folder / "a.txt").write_text(str(len(folders)))

    store.make_many(tmp_path, "step", ["k1"], write)
    with pytest.raises(StoreError, match=r"k1 came out different in: a\.txt"):
        store.make_many(tmp_path, "step", ["k2", "k1"], write, again=True)
