"""The container's lines are those that a clean clone goes through, and what they name is there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def lines(text: str) -> list[str]:
    """Return the lines of a container's file that make something, in order."""
    found = re.findall(r"^RUN (make .*)$|^CMD (\[.*\])$", text, re.M)
    return [run or " ".join(json.loads(command)) for run, command in found]


def test_a_clean_clone_goes_through_the_container_s_own_lines(tmp_path: Path) -> None:
    """The part of .ci/run that does so is run here, on a copy whose `make` only says what it was asked."""
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    part = script[script.index("    xargs rm -rf <.dockerignore") : script.index("    again=$(")]
    tools = tmp_path / "tools"
    tools.mkdir()
    (tools / "make").write_text('#!/bin/sh\necho "make $*" >>asked\n', encoding="utf-8")
    (tools / "make").chmod(0o755)
    clone = tmp_path / "clone"
    clone.mkdir()
    for name in ("Containerfile", ".dockerignore"):
        shutil.copy(ROOT / name, clone / name)
    (clone / "results").mkdir()
    made = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", part],
        cwd=clone,
        env={"PATH": f"{tools}:/usr/bin:/bin", "work": str(tmp_path)},
        check=True,
        capture_output=True,
        text=True,
    )
    text = (ROOT / "Containerfile").read_text(encoding="utf-8")
    assert lines(text)[-1].startswith("make all")
    assert (clone / "asked").read_text(encoding="utf-8").splitlines() == lines(text)
    assert made.stdout.splitlines() == [f"container: {line}" for line in lines(text)]
    assert not (clone / "results").exists()


def test_what_the_container_asks_for_is_there() -> None:
    text = (ROOT / "Containerfile").read_text(encoding="utf-8")
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    assert {line.split()[1] for line in lines(text)} <= set(targets)
    assert {"git", "make"} <= set(re.search(r"recommends (.*?) &&", text)[1].split())


def test_its_python_is_the_project_s() -> None:
    (version,) = re.findall(r"python:(\d+\.\d+)-slim", (ROOT / "Containerfile").read_text(encoding="utf-8"))
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["requires-python"]
    assert wanted.startswith(f">={version},")
    assert f"python:{version}-slim" in (ROOT / "Snakefile").read_text(encoding="utf-8")


def test_nothing_that_was_made_here_goes_into_it() -> None:
    left_out = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    assert {".venv", ".cache", ".snakemake", "results", "reports"} <= set(left_out)
