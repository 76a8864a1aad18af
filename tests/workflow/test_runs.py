"""Whole runs: what they leave, sweeps, mistakes, kills."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pipeline.__main__ import main
from pipeline.kernel import digest, places, store, tables
from tests.making import declared
from tests.workflow.conftest import Project, copy_project, rules

pytestmark = [pytest.mark.workflow]


def _manifest(project: Project, run: str = "default") -> dict[str, object]:
    manifest: dict[str, object] = json.loads(
        (project.folder / "results/solar_reflex" / run / "manifest.json").read_text()
    )
    return manifest


def test_the_view_holds_what_the_manifest_lists(project: Project) -> None:
    manifest = _manifest(project)
    artefacts = manifest["artefacts"]
    assert isinstance(artefacts, list)
    for entry in artefacts:
        assert digest.of_file(project.folder / entry["path"]) == entry["sha256"]
    places = {entry["path"] for entry in artefacts}
    assert "results/solar_reflex/default/charge/same_peak/cc_cv.bdf.parquet" in places
    assert "reports/solar_reflex/default/index.html" in places
    assert manifest["command"] == "snakemake --cores 2 solar_reflex"


def test_the_page_needs_nothing_but_what_is_beside_it(project: Project) -> None:
    folder = project.folder / "reports/solar_reflex/default"
    page = (folder / "index.html").read_text()
    needed = re.findall(r'\bsrc="([^"]*)"', page)
    assert {"run.js", "../../reports.js"} < set(needed)
    assert all((folder / name).is_file() for name in needed)
    assert re.findall(r'<link [^>]*href="(data:image)?', page) == ["data:image"]


def test_the_front_page_leads_to_the_run_and_tells_how_it_was_made(project: Project) -> None:
    reports = project.folder / "reports"
    assert 'href="solar_reflex/default/index.html"' in (reports / "index.html").read_text()
    assert '"snakemake --cores 2 solar_reflex"' in (reports / "solar_reflex/default/run.js").read_text()
    places = {entry["path"] for entry in _manifest(project)["artefacts"]}
    assert "reports/solar_reflex/default/card.json" in places
    assert not {place for place in places if place.endswith(("run.js", "reports.js", "reports/index.html"))}


def test_no_artefact_names_the_folder_it_was_made_in(project: Project) -> None:
    for path in (project.folder / "results/store").rglob("*"):
        if path.is_file():
            assert str(project.folder).encode() not in path.read_bytes(), path


def test_the_found_frequency_is_the_one_charged_with(project: Project) -> None:
    pulses = "'charge.windows=[{start_s:60,length_s:0.05}]' modes.cv_reflex.phases.bulk.until.elapsed_s=50"
    printed = project.snakemake("charges", overrides=f"modes.run=[cc_cv,cv_reflex] {pulses}")
    assert re.search(
        r"charge/same_peak/cc_cv: SOC 0.99 not reached, stopped by the 100 s time limit at SOC 0\.2\d+", printed
    )
    view = _manifest(project)["artefacts"]
    assert isinstance(view, list)
    key = next(entry["key"] for entry in view if entry["step"] == "search")
    found = store.found_value(project.folder / "results/store/search" / key, "frequency_hz")
    waveform = next(project.folder.glob("results/solar_reflex/*bulk*/charge/same_peak/cv_reflex.waveform.parquet"))
    table = tables.read(declared("charge")["waveform"].table, waveform)
    current = table["current_a"]
    begins = table["time_s"][1:][(current[:-1] <= 0.0) & (current[1:] > 1.0)]
    assert len(begins) >= 3
    assert np.diff(begins) == pytest.approx(1.0 / found, rel=1e-6)


def test_a_sweep_shares_what_is_the_same(project: Project) -> None:
    printed = project.run("pipeline", "-m", "battery=lead_acid_12v7ah,lead_acid_12v18ah", "-n")
    assert "fit_panel" not in rules(printed)
    plans = sorted((project.folder / "results/plan").glob("*.json"), key=lambda path: path.stat().st_mtime)
    plan = json.loads(plans[-1].read_text())
    steps = [node["step"] for node in plan["nodes"].values()]
    assert list(plan["runs"][0]["sweep"]) == ["battery=lead_acid_12v7ah", "battery=lead_acid_12v18ah"]
    assert steps.count("panel") == steps.count("supply") == steps.count("engine") == 1
    # Of each battery the constant current, which both comparisons leave as it is, and the pulses in each of them.
    assert steps.count("charge") == 6
    assert steps.count("sweep") == steps.count("sweep_page") == 1
    assert not {"figures", "page", "verdicts", "ensemble"} & set(steps)


MISTAKES = {
    "battery=lead_acid": ("lead_acid_12v7ah",),
    "battery.capacty_ah=7": ("battery", "capacity_ah"),
    "battery.capacity_ah=-7": ("battery.capacity_ah", "-7", "more than 0"),
    "battery.capacity_ah=nan": ("battery.capacity_ah", "finite"),
    "battery.thermal.resistance_k_w=x": ("battery.thermal.resistance_k_w", "x"),
    "charge.initial_soc=1.2": ("charge.initial_soc", "1.2"),
    "modes.run=[cc_cv,cv_refleks]": ("cv_refleks", "cv_reflex"),
    "modes.cv_reflex.charge_share=0.97": ("cv_reflex", "share"),
    "modes.cv_reflex.charge_a=-2": ("cv_reflex", "charge_a"),
    "modes.cc_cv.voltage_v=11": ("cc_cv", "11"),
    "+modes.cv_reflex.charge_aa=2": ("charge_aa", "charge_a"),
    "+panel.colour=3": ("panel.colour", "unknown key"),
    "panel.max_power_voltage_v=40": ("panel", "40", "open_circuit_voltage_v"),
    "load.power_w=100": ("load.power_w", "100"),
    "comparisons.same_mean.mean_current_of=cc": ("mean_current_of", "cc_cv"),
    "sed=3": ("sed", "seed"),
    "modes.cv_reflex.frequency_hz={from:serach,value:frequency_hz}": ("cv_reflex.frequency_hz", "'serach'", "search"),
    "search.c1={from:tuning,value:c4}": ("search.c1", "'c4'", "c1"),
    "=": ("key=value",),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_ends_with_one_message_before_anything_runs(
    mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([mistake]) == 2
    printed = capsys.readouterr()
    _is_one_message(mistake, printed.out, printed.err)
    assert list(tmp_path.iterdir()) == []


def test_it_ends_so_in_a_terminal(tmp_path: Path) -> None:
    mistake = "battery.capacty_ah=7"
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", mistake],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(places.PACKAGE.parent)},
    )
    assert done.returncode == 2, done.stdout + done.stderr
    _is_one_message(mistake, done.stdout, done.stderr)
    assert list(tmp_path.iterdir()) == []


def _is_one_message(mistake: str, out: str, error: str) -> None:
    assert out == ""
    assert error.startswith("error: ")
    assert "Traceback" not in error
    for word in MISTAKES[mistake]:
        assert word in error


def test_snakemake_says_the_same_and_leaves_results_alone(project: Project) -> None:
    before = sorted((project.folder / "results").rglob("*"))
    printed = project.snakemake(overrides="battery.capacty_ah=7", code=2)
    assert "best matches are: capacity_ah" in printed
    assert "Traceback" not in printed
    assert sorted((project.folder / "results").rglob("*")) == before


@pytest.mark.slow
def test_a_killed_run_goes_on_with_the_same_command(tmp_path: Path) -> None:
    project = copy_project(tmp_path / "project")
    environment = os.environ | {"PYTHONPATH": str(project.folder / "src")}
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "tuning"]
    job = subprocess.Popen(
        command,
        cwd=project.folder,
        env=environment,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    store = project.folder / "results" / "store"
    deadline = time.monotonic() + 60
    while not store.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    os.killpg(job.pid, signal.SIGKILL)
    job.wait()
    project.snakemake("tuning")
    assert "1 artefacts whole, 0 damaged" in project.run("pipeline", "store", "verify")
    assert (project.folder / "results/solar_reflex/default/tuning/rerun.runs.parquet").is_file()
    subprocess.run(["chmod", "-R", "u+w", str(project.folder)], check=True)
