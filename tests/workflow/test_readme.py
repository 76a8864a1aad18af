"""What docs/adding.md says is written into a copy of the project and run there, line by line."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.kernel import registry
from tests.workflow.conftest import Project
from tests.workflow.parts import ROOT, copy_parts

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

ADDING = (ROOT / "docs" / "adding.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```$", ADDING, re.MULTILINE | re.DOTALL)
FILES = {place: text for _, place, text in BLOCKS if place}
COMMANDS = [line for language, _, text in BLOCKS if language == "sh" for line in text.splitlines()]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    folder = tmp_path_factory.mktemp("adding") / "project"
    copy_parts(folder)
    for place, text in FILES.items():
        path = folder / place
        assert not path.exists(), f"{place} is there already"
        path.write_text(text)
    return Project(folder)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_line_of_the_readme_runs(project: Project, command: str) -> None:
    words = shlex.split(command)
    if words[:2] == ["python", "-m"]:
        project.run(*words[2:])
    else:
        project.snakemake(*[word for word in words[1:] if word not in ("--cores", "2")])


def test_the_skeleton_passes_its_own_test(project: Project) -> None:
    for place in ("tests/__init__.py", "tests/experiments/__init__.py", "tests/making.py"):
        target = project.folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text((ROOT / place).read_text())
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/experiments/resting"],
        cwd=project.folder,
        env={"PYTHONPATH": f"{project.folder / 'src'}:{project.folder}", "PATH": "/usr/bin:/bin", "HOME": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "1 passed" in done.stdout, done.stdout + done.stderr


def test_the_chain_of_the_workflow_is_shown_whole() -> None:
    shown = (ROOT / "workflow" / "README.md").read_text(encoding="utf-8")
    order = [shown.find(f"\n{name} ") for name in registry.steps()]
    assert min(order) >= 0, [name for name, place in zip(registry.steps(), order, strict=True) if place < 0]
    assert Path(ROOT / "workflow" / "steps.smk").is_file()


def test_the_readme_is_short_and_leads_to_every_page() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) <= 150
    listed = set(re.findall(r"\(docs/([\w-]+\.md)\)", readme))
    assert listed == {path.name for path in (ROOT / "docs").glob("*.md")}
