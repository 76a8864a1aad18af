"""Two runs in one folder at once: the second waits, whatever it is, and both end as each would alone."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from pipeline.kernel import digest, lock
from tests.workflow.conftest import Project, small_project
from tests.workflow.parts import ROOT

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@contextmanager
def _begun(project: Project, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Start a command; it ends, well, before this does."""
    environment = os.environ | {
        "PYTHONPATH": str(project.folder / "src"),
        "CHARGE_PIPELINE_CACHE": str(ROOT / ".cache"),
    }
    process = subprocess.Popen(
        [sys.executable, "-m", *words],
        cwd=project.folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield process
        assert process.stdout is not None
        told = process.stdout.read()
        assert process.wait() == 0, told
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


def _await(path: Path) -> None:
    deadline = time.monotonic() + 120
    while not path.exists():
        assert time.monotonic() < deadline, f"{path} does not come"
        time.sleep(0.02)


def _shown(project: Project, run: str) -> dict[str, str]:
    folder = project.folder / "results" / "resting_study" / run
    return {
        path.relative_to(folder).as_posix(): digest.of_file(path)
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith("manifest")
    }


@pytest.mark.parametrize("second", ["snakemake", "pipeline"])
def test_the_second_of_two_different_runs_waits(second: str, tmp_path: Path) -> None:
    project = small_project(tmp_path / "project")
    with _begun(project, "pipeline", "study=resting_study", "-t", "resting"):
        _await(project.folder / "results" / lock.RUN)
        if second == "pipeline":
            told = project.run("pipeline", "study=resting_study", "resting.points=11", "-t", "resting")
        else:
            told = project.snakemake("resting", overrides="study=resting_study resting.points=11")
    assert told.count("waiting until it ends") == 1
    assert "(python -m pipeline study=resting_study -t resting)" in told
    together = [_shown(project, run) for run in ("default", "resting.points=11")]
    assert all(together)
    assert together[0] != together[1]
    subprocess.run(["chmod", "-R", "u+w", str(project.folder / "results")], check=True)
    subprocess.run(["rm", "-r", str(project.folder / "results")], check=True)
    project.snakemake("resting")
    project.run("pipeline", "study=resting_study", "resting.points=11", "-t", "resting")
    assert [_shown(project, run) for run in ("default", "resting.points=11")] == together


def test_who_only_looks_waits_for_nobody(small: Project) -> None:
    with lock.held(small.folder / "results", pytest.fail):
        for words in (("-n", "all"), ("-np", "all"), ("--list-rules",), ("--summary",), ("--dag", "dot", "all")):
            assert "waiting" not in small.snakemake(*words)
        assert "Nothing to be done" in small.run("pipeline", "study=resting_study", "-n")
