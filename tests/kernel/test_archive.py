"""Artefacts go through an archive as they are; what is not as it was sealed does not come in."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest

from pipeline.kernel import archive, planfile, receipts, run, store
from tests.faults import instant

KEYS = ("a" * 64, "b" * 64)


def _write(folder: Path) -> None:
    (folder / "one.txt").write_text(folder.name[1:3])
    (folder / "part").mkdir()
    (folder / "part" / "two.txt").write_text("2")


def _packed(tmp_path: Path, name: str = "one.tar") -> Path:
    for key in KEYS:
        store.make(tmp_path / "there", "step", key, _write)
    archive.pack(tmp_path / "there", "step", KEYS, tmp_path / name)
    return tmp_path / name


def test_artefacts_come_out_as_they_went_in(tmp_path: Path) -> None:
    packed = _packed(tmp_path)
    assert archive.unpack(tmp_path / "here", packed) == list(KEYS)
    for key in KEYS:
        there, here = (store.artefact(tmp_path / name, "step", key) for name in ("there", "here"))
        assert store.damage(here) is None
        assert store.contents(here) == store.contents(there)
    assert list(tmp_path.glob(".*")) == []


def test_its_bytes_depend_on_the_artefacts_alone(tmp_path: Path) -> None:
    first = _packed(tmp_path).read_bytes()
    archive.unpack(tmp_path / "here", tmp_path / "one.tar")
    archive.pack(tmp_path / "here", "step", reversed(KEYS), tmp_path / "two.tar")
    assert (tmp_path / "two.tar").read_bytes() == first


def test_what_is_there_stays(tmp_path: Path) -> None:
    packed = _packed(tmp_path)
    archive.unpack(tmp_path / "here", packed)
    before = [(path, path.stat().st_ino) for path in sorted((tmp_path / "here").rglob("*"))]
    archive.unpack(tmp_path / "here", packed)
    assert [(path, path.stat().st_ino) for path in sorted((tmp_path / "here").rglob("*"))] == before


def test_a_damaged_artefact_does_not_come_in(tmp_path: Path) -> None:
    packed = _packed(tmp_path)
    with tarfile.open(packed, "a") as tar:
        entry = tarfile.TarInfo(f"step/{KEYS[0]}/one.txt")
        entry.size, entry.mode = 3, 0o644
        tar.addfile(entry, io.BytesIO(b"bad"))
    with pytest.raises(store.StoreError, match=r"one\.txt changed since it was sealed"):
        archive.unpack(tmp_path / "here", packed)
    assert not (tmp_path / "here" / "store" / "step" / KEYS[0]).exists()


@pytest.mark.parametrize("name", ["../step/key/file", "/etc/key/file", "step/file"])
def test_a_file_that_belongs_elsewhere_is_refused(tmp_path: Path, name: str) -> None:
    with tarfile.open(tmp_path / "bad.tar", "w") as tar:
        tar.addfile(tarfile.TarInfo(name))
    with pytest.raises(store.StoreError, match="no file of an artefact"):
        archive.unpack(tmp_path / "here", tmp_path / "bad.tar")


def test_what_is_no_archive_is_said(tmp_path: Path) -> None:
    (tmp_path / "bad.tar").write_text("no archive")
    with pytest.raises(store.StoreError, match="no archive of artefacts"):
        archive.unpack(tmp_path / "here", tmp_path / "bad.tar")


def test_a_damaged_artefact_is_not_packed(tmp_path: Path) -> None:
    _packed(tmp_path)
    victim = store.artefact(tmp_path / "there", "step", KEYS[1]) / "one.txt"
    victim.chmod(0o644)
    victim.write_text("changed")
    with pytest.raises(store.StoreError, match="changed since it was sealed"):
        archive.pack(tmp_path / "there", "step", KEYS, tmp_path / "two.tar")
    assert not (tmp_path / "two.tar").exists()


def test_a_job_takes_and_gives_what_is_carried(tmp_path: Path) -> None:
    """The second step runs where nothing is but what the first one gave."""
    file = planfile.save(instant.plan(), tmp_path / "results")
    there, here = tmp_path / "there" / "results", tmp_path / "here" / "results"
    carried = [tmp_path / "carried" / "first.json", tmp_path / "carried" / "first.tar"]

    def job(results: Path, step: str, *words: str) -> int:
        plan = ["--plan", str(file), "--step", step, "--chunk", f"{step}-50", "--results", str(results)]
        return run.main([*plan, *words])

    assert job(here, "second") == 1
    assert job(there, "first", "--give", *map(str, carried)) == 0
    assert carried[0].read_text() == receipts.path_of(there, "first", "first-50").read_text()
    assert job(here, "second", "--take", *map(str, carried)) == 0
    assert job(there, "second") == 0
    for step in ("first", "second"):
        (made,) = (here / "store" / step).iterdir()
        assert store.damage(made) is None
        assert store.contents(made) == store.contents(store.artefact(there, step, made.name))
