"""A step opens its inputs, the files it declared, and nothing else of the project."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.kernel import registry
from tests.workflow.conftest import Project

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

WATCH = """
import json, os, sys
opened = set()

def hook(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, os.PathLike)):
        opened.add(os.path.realpath(arguments[0]))

sys.addaudithook(hook)
from pipeline.kernel.run import main
code = main(sys.argv[2:])
with open(sys.argv[1], "w") as file:
    json.dump(sorted(opened), file)
sys.exit(code)
"""


def _opened(project: Project, step: str, tmp_path: Path) -> set[Path]:
    """Run the first chunk of a step again and return the project's files it opened, compiled code left out."""
    plan_file = max((project.folder / "results/plan").glob("*.json"), key=lambda path: path.stat().st_mtime)
    chunks = json.loads(plan_file.read_text())["chunks"]
    chunk = next(name for name, chunk in chunks.items() if chunk["step"] == step)
    report = tmp_path / "opened.json"
    words = ["--plan", str(plan_file), "--step", step, "--chunk", chunk, "--again"]
    done = subprocess.run(
        [sys.executable, "-c", WATCH, str(report), *words],
        cwd=project.folder,
        env={"PYTHONPATH": str(project.folder / "src"), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    folder = project.folder.resolve()
    paths = {Path(path) for path in json.loads(report.read_text())}
    return {path.relative_to(folder) for path in paths if path.is_relative_to(folder) and path.is_file()}


# The steps of the study that the copied project has; those of others are watched where these are run.
STEPS = (
    "panel", "supply", "chaos", "objective", "tuning", "search", "engine", "charge", "ensemble", "weather", "daylight",
    "objective_ensemble", "search_ensemble", "switched_ensemble",
    "day", "tracking", "converters", "verdicts", "figures", "page",
)  # fmt: skip


@pytest.mark.parametrize("step", STEPS)
def test_a_step_opens_only_what_it_declared(project: Project, step: str, tmp_path: Path) -> None:
    opens_only_what_it_declared(project, step, tmp_path)


def opens_only_what_it_declared(project: Project, step: str, tmp_path: Path) -> None:
    """Fail where a step opens a file of the project that it did not declare."""
    declared = {path for pattern in registry.steps()[step].files for path in project.folder.glob(pattern)}
    known = {path.relative_to(project.folder) for path in declared}
    for path in _opened(project, step, tmp_path) - known:
        is_code = path.suffix == ".py" or "__pycache__" in path.parts or path.parts[0] == ".cache"
        is_store = path.parts[:2] in {("results", name) for name in ("store", "plan", "receipts", ".jobs")}
        assert is_code or is_store or path == Path("requirements.lock"), (
            f"{step} opened {path}, which it did not declare"
        )
