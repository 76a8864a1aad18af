"""A whole run against what is expected: as it lies there, made anew in a fresh folder, and as another CPU makes it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.workflow.conftest import Project

pytestmark = [pytest.mark.workflow]


@pytest.fixture(scope="module")
def expected(project: Project, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("expected") / "expected.json"
    project.run("pipeline", "reproduce", "--renew", "--results", "results", "--expected", str(file))
    return file


def test_what_is_recorded_is_as_it_was_made(project: Project, expected: Path) -> None:
    told = project.run("pipeline", "reproduce", "--results", "results", "--expected", str(expected))
    assert "byte by byte" in told
    assert "0 differ; no number differs" in told
    run = json.loads(expected.read_text())["runs"]["solar_reflex/default"]
    assert run["found"]["search"]["frequency_hz"] > 1.0
    assert set(run["verdicts"]) == {"results/published/verdicts.parquet", "results/second/verdicts.parquet"}
    # A chaotic column is left out, the others of its table are not.
    assert run["tables"]["results/chaos/orbit.parquet"].keys() == {"rows", "r", "step"}


@pytest.mark.parametrize("edit", ["found", "number", "verdict", "cell of a table"])
def test_another_number_is_told(edit: str, project: Project, expected: Path, tmp_path: Path) -> None:
    told = json.loads(expected.read_text())
    run = told["runs"]["solar_reflex/default"]
    if edit == "found":
        run["found"]["search"]["frequency_hz"] *= 1.1
    elif edit == "number":
        run["numbers"]["results/objective/quantities.parquet"]["optimal_frequency_hz"] *= 1.1
    elif edit == "verdict":
        verdicts = run["verdicts"]["results/published/verdicts.parquet"]
        verdicts[next(iter(verdicts))] = "made up"
    else:
        run["tables"]["results/charge/same_peak/cc_cv.bdf.parquet"]["soc"]["most"] += 0.01
    told["machine"]["cpu"] = "another"
    file = tmp_path / "edited.json"
    file.write_text(json.dumps(told))
    printed = project.run("pipeline", "reproduce", "--results", "results", "--expected", str(file), code=1)
    assert "by value, since this is another machine than the recorded one" in printed
    assert ", 1 differ; " in printed


@pytest.mark.struck
def test_a_cold_run_under_other_conditions_is_the_same_byte_for_byte(
    project: Project, expected: Path, tmp_path: Path
) -> None:
    cold = tmp_path / "a cold run"
    told = project.run("pipeline", "reproduce", "--expected", str(expected), "--folder", str(cold))
    assert "TZ=Asia/Tokyo" in told
    assert "--cores 3 all" in told
    assert "byte by byte" in told
    assert "0 differ; no number differs" in told
    assert (cold / "reports/solar_reflex/default/index.html").is_file()


@pytest.mark.struck
def test_another_cpu_finds_the_same_within_tolerances(project: Project, expected: Path) -> None:
    told = project.run("pipeline", "reproduce", "--expected", str(expected), "--generic")
    assert "cpu: generic; recorded: " in told
    assert ", 0 differ; " in told
    # Another CPU was played indeed: something is off in its last digits.
    assert re.search(r"largest difference let pass: \S+e-\d+ of ", told)
