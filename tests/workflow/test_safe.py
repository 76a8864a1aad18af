"""What a person may write stays text: at both front doors, really run."""

from __future__ import annotations

import shlex
import subprocess
from collections.abc import Iterator

import pytest

from tests.workflow.conftest import Project
from tests.workflow.parts import copy_parts

TITLE = "<script>alert(1)</script>{{ 7*7 }}{% if %}$(touch pwned)`touch pwned`;touch pwned&|<b>&amp;"
# Snakemake takes quotes from both ends of a value: the word that has them stands at neither.
WORDS = [f"study.title='{TITLE}'", "study=resting_study"]


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Project]:
    """A copy of the project with a study of one small step."""
    project = Project(tmp_path_factory.mktemp("safe") / "project")
    copy_parts(project.folder)
    project.run("pipeline", "new", "experiment", "resting")
    yield project
    subprocess.run(["chmod", "-R", "u+w", str(project.folder)], check=True)


@pytest.mark.slow
@pytest.mark.parametrize("door", ["pipeline", "snakemake"])
def test_a_title_is_text_wherever_it_goes(tiny: Project, door: str) -> None:
    if door == "pipeline":
        tiny.run("pipeline", "seed=7", *WORDS, "-c", "1")
    else:
        tiny.run("snakemake", "--cores", "1", "all", "--config", f"overrides={shlex.join(['seed=8', *WORDS])}")
    seed = {"pipeline": "seed=7", "snakemake": "seed=8"}[door]
    (page,) = tiny.folder.glob(f"reports/resting_study/{seed}*/index.html")
    html = page.read_text()
    assert "&lt;script&gt;alert(1)" in html
    assert "<script>alert(1)" not in html
    assert "{{ 7*7 }}" in html
    assert not list(tiny.folder.rglob("pwned*"))
    made = {path.name for path in tiny.folder.iterdir()}
    assert made - {"Snakefile", "workflow", "profiles", "conf", "src", "requirements.lock", "tests"} == {
        *("results", "reports", ".snakemake"),
    }
