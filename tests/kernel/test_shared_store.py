"""The store on a network's file system: no links, no renaming of folders, folders seen late, jobs of other machines."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import shutil
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.kernel import lock, receipts, store

KEY, OTHER = "a" * 64, "b" * 64


def _write(folder: Path) -> None:
    (folder / "one.txt").write_text("1")
    (folder / "part").mkdir()
    (folder / "part" / "two.txt").write_text("2")


def _refusing(call: Callable[..., Any], number: int, when: Callable[..., bool]) -> Callable[..., Any]:
    def called(*arguments: Any, **words: Any) -> Any:
        if when(*arguments):
            raise OSError(number, os.strerror(number), str(arguments[0]))
        return call(*arguments, **words)

    return called


@pytest.fixture(params=[errno.EPERM, errno.EXDEV, errno.ENOTEMPTY, errno.ENOTSUP])
def network(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Refuse links, renaming of folders, waiting for folders, and locks, as a file system of a network may."""
    number: int = request.param
    folder_of = os.fstat
    monkeypatch.setattr(os, "link", _refusing(os.link, number, lambda *_: True))
    for name in ("rename", "replace"):
        monkeypatch.setattr(os, name, _refusing(getattr(os, name), number, lambda source, *_: Path(source).is_dir()))
    is_folder = lambda descriptor: stat.S_ISDIR(folder_of(descriptor).st_mode)  # noqa: E731
    monkeypatch.setattr(os, "fsync", _refusing(os.fsync, errno.EINVAL, is_folder))
    monkeypatch.setattr(fcntl, "flock", _refusing(fcntl.flock, errno.ENOLCK, lambda *_: True))
    return number


@pytest.mark.usefixtures("network")
def test_an_artefact_is_made_sealed_and_found(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _write)
    folder = store.whole(tmp_path, "step", KEY, "input x")
    assert store.damage(folder) is None
    assert store.contents(folder) == made
    assert sorted(made) == ["one.txt", "part/two.txt"]
    assert stat.S_IMODE((folder / "part" / "two.txt").stat().st_mode) == 0o444
    assert [path.name for path in folder.parent.iterdir()] == [KEY]


@pytest.mark.usefixtures("network")
def test_many_are_made_and_compared(tmp_path: Path) -> None:
    made = store.make_many(tmp_path, "step", [KEY, OTHER], lambda folders: [_write(one) for one in folders.values()])
    assert (
        store.make_many(tmp_path, "step", [KEY, OTHER], lambda folders: [_write(one) for one in folders.values()], True)
        == made
    )
    assert {path.name for path in (tmp_path / "store" / "step").iterdir()} == {KEY, OTHER}


@pytest.mark.usefixtures("network")
def test_damage_is_moved_away_and_mended(tmp_path: Path) -> None:
    made = store.make(tmp_path, "step", KEY, _write)
    victim = store.artefact(tmp_path, "step", KEY) / "one.txt"
    victim.chmod(0o644)
    victim.write_text("changed")
    with pytest.raises(store.StoreError, match="changed since it was sealed"):
        store.whole(tmp_path, "step", KEY, "input x")
    assert not store.artefact(tmp_path, "step", KEY).exists()
    (away,) = (tmp_path / "quarantine").rglob("one.txt")
    assert away.read_text() == "changed"
    assert store.make(tmp_path, "step", KEY, _write) == made


@pytest.mark.usefixtures("network")
def test_a_link_is_a_copy(tmp_path: Path) -> None:
    store.make(tmp_path, "step", KEY, _write)
    source = store.artefact(tmp_path, "step", KEY) / "one.txt"
    for _ in range(2):
        store.link(source, tmp_path / "view" / "one.txt")
    assert (tmp_path / "view" / "one.txt").read_text() == "1"
    assert (tmp_path / "view" / "one.txt").stat().st_ino != source.stat().st_ino
    assert [path.name for path in (tmp_path / "view").iterdir()] == ["one.txt"]


@pytest.mark.usefixtures("network")
def test_a_job_that_ends_while_it_copies_leaves_nothing_that_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copied: list[object] = []

    def copyfile(source: Path, target: Path) -> None:
        copied.append(source)
        if len(copied) > 1:
            raise KeyboardInterrupt
        target.write_bytes(source.read_bytes())

    with monkeypatch.context() as patched:
        patched.setattr(shutil, "copyfile", copyfile)
        with pytest.raises(KeyboardInterrupt):
            store.make(tmp_path, "step", KEY, _write)
    folder = store.artefact(tmp_path, "step", KEY)
    assert folder.exists()
    assert store.damage(folder) is not None
    made = store.make(tmp_path, "step", KEY, _write)
    assert store.contents(folder) == made
    assert store.damage(folder) is None


@pytest.mark.usefixtures("network")
def test_receipts_and_locks_do_without(tmp_path: Path) -> None:
    said: list[str] = []
    lock.take(tmp_path / "results", said.append)
    lock.release(tmp_path / "results")
    with lock.at_work(tmp_path / "results"):
        made = store.make(tmp_path / "results", "step", KEY, _write)
        receipts.write(tmp_path / "results", "step", "one-1", {KEY: made}, {})
    chunks = {"one-1": {"step": "step", "nodes": [KEY], "needs": []}}
    assert receipts.drop_broken(tmp_path / "results", chunks, verify=True, say=said.append) == []
    assert said == []


def test_a_full_disk_is_no_file_system_without_renames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is refused for another reason is refused in the copy too, and said."""
    monkeypatch.setattr(os, "replace", _refusing(os.replace, errno.ENOSPC, lambda source, *_: Path(source).is_dir()))
    monkeypatch.setattr(shutil, "copyfile", _refusing(shutil.copyfile, errno.ENOSPC, lambda *_: True))
    with pytest.raises(OSError, match="No space left"):
        store.make(tmp_path, "step", KEY, _write)


def test_what_another_machine_is_writing_stays(tmp_path: Path) -> None:
    """Its processes cannot be asked: the same number may be that of a process that is no more here."""
    parent = store.artefact(tmp_path, "step", KEY).parent
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    (parent / f".{OTHER}.abcdefgh.0badcafe-{ended.pid}").mkdir(parents=True)
    old = parent / f".{OTHER}.hgfedcba.0badcafe-{ended.pid}"
    old.mkdir()
    week_ago = time.time() - 9 * 86_400
    os.utime(old, (week_ago, week_ago))
    machine = hashlib.sha256(socket.gethostname().encode()).hexdigest()[:8]
    mine = parent / f".{OTHER}.abcdefgh.{machine}-{ended.pid}"
    mine.mkdir()
    assert set(store.abandoned(tmp_path)) == {old, mine}
    store.make(tmp_path, "step", KEY, _write)
    assert {path.name for path in parent.iterdir()} == {KEY, f".{OTHER}.abcdefgh.0badcafe-{ended.pid}"}


def test_an_input_that_is_seen_late_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "patience_s", 20.0)
    asked = threading.Event()

    def late() -> None:
        asked.wait(20.0)
        store.make(tmp_path, "step", KEY, _write)

    other = threading.Thread(target=late)
    other.start()
    sleep = time.sleep
    monkeypatch.setattr(time, "sleep", lambda seconds: (asked.set(), sleep(0.01)))
    try:
        assert store.damage(store.whole(tmp_path, "step", KEY, "input x")) is None
    finally:
        other.join()


def test_an_input_that_never_comes_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "patience_s", 0.02)
    with pytest.raises(store.StoreError, match="no sealed artefact"):
        store.whole(tmp_path, "step", KEY, "input x")
