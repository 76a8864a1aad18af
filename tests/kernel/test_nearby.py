"""Kernels come to a node's own disk before a job's step is imported, and go back where they were compiled there."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pipeline.kernel import nearby
from pipeline.kernel.code import of_code
from pipeline.kernel.places import cache_root

MODULE = "pipeline.kernel.digest"


@pytest.fixture
def node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a shared cache and a node's disk, and be a job; return the node's folder."""
    monkeypatch.setenv("CHARGE_PIPELINE_CACHE", str(tmp_path / "shared"))
    monkeypatch.setenv("SLURM_TMPDIR", str(tmp_path))
    monkeypatch.setenv("SLURM_JOB_ID", "7")
    monkeypatch.setattr(nearby, "_shared", {})
    return tmp_path / f"charge-pipeline-{os.getuid()}"


def _kernels(root: Path) -> Path:
    return root / "numba" / of_code(MODULE)[:16]


def _written(folder: Path, **files: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text)


def _read(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_kernels_come_and_go(node: Path, tmp_path: Path) -> None:
    _written(_kernels(tmp_path / "shared"), a_nbi="index", a_nbc="code")
    nearby.bring(MODULE)
    assert cache_root() == node
    assert _read(_kernels(node)) == {"a.nbi": "index", "a.nbc": "code"}
    _written(_kernels(node), b_nbc="compiled here")
    nearby.give_back(MODULE)
    assert _read(_kernels(tmp_path / "shared")) == {"a.nbi": "index", "a.nbc": "code", "b.nbc": "compiled here"}


def test_an_older_index_does_not_replace_a_younger(node: Path, tmp_path: Path) -> None:
    _written(_kernels(node), a_nbi="younger")
    node.chmod(0o700)
    _written(_kernels(tmp_path / "shared"), a_nbi="older")
    os.utime(_kernels(tmp_path / "shared") / "a.nbi", (1.0, 1.0))
    nearby.bring(MODULE)
    assert _read(_kernels(node)) == {"a.nbi": "younger"}


def test_a_folder_of_another_user_is_not_used(node: Path, tmp_path: Path) -> None:
    node.mkdir()
    node.chmod(0o777)
    _written(_kernels(tmp_path / "shared"), a_nbi="index")
    nearby.bring(MODULE)
    assert cache_root() == tmp_path / "shared"
    node.rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    node.symlink_to(tmp_path / "elsewhere")
    nearby.bring(MODULE)
    assert cache_root() == tmp_path / "shared"


def test_nothing_is_done_on_a_machine_of_ones_own(node: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SLURM_JOB_ID")
    _written(_kernels(tmp_path / "shared"), a_nbi="index")
    nearby.bring(MODULE)
    nearby.give_back(MODULE)
    assert cache_root() == tmp_path / "shared"
    assert not node.exists()


def test_a_shared_cache_that_cannot_be_read_is_no_fault(node: Path) -> None:
    nearby.bring(MODULE)
    nearby.give_back(MODULE)
    assert cache_root() == node
