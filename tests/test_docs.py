"""The commands and the code of the README and of docs/ are those that work."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import matplotlib
import pytest

from pipeline.commands import COMMANDS
from pipeline.config.compose import compose_tree, expand
from pipeline.config.study import study_from
from pipeline.kernel import registry

ROOT = Path(__file__).resolve().parents[1]
# What docs/adding.md has is run in a copy of the project, by tests/workflow/test_readme.py.
PAGES = sorted({ROOT / "README.md", *(ROOT / "docs").glob("*.md")} - {ROOT / "docs" / "adding.md"})
TEXTS = {page.name: page.read_text(encoding="utf-8") for page in PAGES}
CODE = [
    (name, code) for name, text in TEXTS.items() for code in re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
]
LINES = [
    line
    for text in TEXTS.values()
    for block in re.findall(r"^```\n(.*?)^```$", text, re.M | re.S)
    for line in block.splitlines()
]
TYPED = sorted({line.split("#")[0].strip() for line in LINES if line.startswith(("python -m pipeline", "snakemake"))})
MADE_UP = ("NAME", "FILE", "OTHER", "FOLDER")


@pytest.mark.parametrize(("page", "code"), CODE)
def test_code_runs(page: str, code: str) -> None:
    matplotlib.use("Agg")
    names: dict[str, Any] = {}
    exec(compile(code, page, "exec"), names)


def _words(line: str) -> list[str]:
    if line.startswith("snakemake"):
        given = re.search(r'overrides="([^"]*)"', line)
        return shlex.split(given[1]) if given else []
    return [word for word in shlex.split(line)[3:] if not word.startswith("-")]


@pytest.mark.parametrize("line", TYPED)
def test_a_command_is_understood(line: str) -> None:
    words = _words(line)
    if (words and words[0] in COMMANDS) or any(name in line for name in MADE_UP):
        assert words[0] in COMMANDS or any("=" in word for word in words)
        return
    for run in expand(words):
        study_from(compose_tree(run))


@pytest.mark.parametrize("line", [line for line in TYPED if line.startswith("snakemake")])
def test_a_target_is_there(line: str) -> None:
    words = shlex.split(line)[1:]
    target = next(word for word in words if not word.startswith("-") and not word.isdecimal())
    studies = {path.stem for path in (ROOT / "conf" / "study").glob("*.yaml")}
    assert target in {"all", *registry.targets(), *studies} or target.split("/")[0] in ("results", "reports")
