"""The container's lines are those that a clean clone goes through: what they name is there."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_the_container_runs_what_a_clean_clone_runs() -> None:
    text = (ROOT / "Containerfile").read_text(encoding="utf-8")
    command = " ".join(re.findall(r'"([^"]+)"', re.search(r"^CMD (.*)$", text, re.M)[1]))
    assert command.replace("make ", "", 1) in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    asked = re.findall(r"\bmake ([a-z-]+)", text.replace('", "', " "))
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    assert set(asked) - {"all"} <= set(targets)
    assert {"git", "make"} <= set(re.search(r"recommends (.*?) &&", text)[1].split())


def test_its_python_is_the_project_s() -> None:
    (version,) = re.findall(r"python:(\d+\.\d+)-slim", (ROOT / "Containerfile").read_text(encoding="utf-8"))
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["requires-python"]
    assert wanted.startswith(f">={version},")
    assert f"python:{version}-slim" in (ROOT / "Snakefile").read_text(encoding="utf-8")


def test_nothing_that_was_made_here_goes_into_it() -> None:
    left_out = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    assert {".venv", ".cache", ".snakemake", "results", "reports"} <= set(left_out)
