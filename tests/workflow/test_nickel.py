"""The nickel-cadmium study from one end to the other, its network small."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pipeline.grnn.charger_network import ChargerNetwork
from pipeline.grnn.network import command
from pipeline.kernel import store, tables
from tests.experiments.network.artefacts import SMALL
from tests.making import declared
from tests.workflow.conftest import Project
from tests.workflow.parts import copy_parts
from tests.workflow.test_declared_files import opens_only_what_it_declared

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

FEWER = ("trade_off.c_rates=[4.0,8.0]", "ensemble={points:2,slow_points:2,experiments:2}")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Project, Path, Path]]:
    """The project after a run of the study, the view of its results and that of its report."""
    project = Project(tmp_path_factory.mktemp("nickel") / "project")
    copy_parts(project.folder)
    words = " ".join(word.replace(" ", "") for word in (*SMALL, *FEWER))
    project.snakemake("nicd_grnn", overrides=words)
    (view,) = (project.folder / "results" / "nicd_grnn").iterdir()
    (report,) = (project.folder / "reports" / "nicd_grnn").iterdir()
    yield project, view, report
    subprocess.run(["chmod", "-R", "u+w", str(project.folder)], check=True)


def test_the_found_network_commands_the_charge(made: tuple[Project, Path, Path]) -> None:
    project, view, _ = made
    manifest = json.loads((view / "manifest.json").read_text())
    key = next(entry["key"] for entry in manifest["artefacts"] if entry["step"] == "network")
    found = store.found_value(project.folder / "results/store/network" / key, "genetic")
    network = ChargerNetwork.model_validate(found).compiled()
    trace = tables.read(declared("charge")["trace"].table, view / "charge/stopped/grnn.bdf.parquet")
    temperature = np.concatenate([[30.0], trace["Surface Temperature / degC"]])
    for second in (5, 100, 300, 450):
        rate = temperature[second - 1] - temperature[second - 2]
        expected = 0.6 * command(network, temperature[second - 1], rate)
        assert trace["Current / A"][second] == pytest.approx(expected, rel=1e-5)


def test_the_trade_off_holds_what_was_asked(made: tuple[Project, Path, Path]) -> None:
    table = tables.read(declared("trade_off")["trade_off"].table, made[1] / "trade_off" / "trade_off.parquet")
    assert set(table["law"]) == {"constant_current", "grnn", "plain_rule"}
    assert len(table["law"]) == 2 * 4 * 4 + 2 * 4 + 2 * 5


def test_the_page_answers(made: tuple[Project, Path, Path]) -> None:
    page = (made[2] / "index.html").read_text()
    assert "Is the network worth it?" in page
    assert "in this model: the plain rule" in page
    for name in ("figure_3_current_source", "figure_9_network_charge", "trade_off", "sensors"):
        assert (made[2] / "figures" / f"{name}.svg").is_file()


def test_statements_are_judged_and_what_the_small_network_lacks_is_said(made: tuple[Project, Path, Path]) -> None:
    verdicts = tables.read(declared("verdicts")["verdicts"].table, made[1] / "published" / "verdicts.parquet")
    of = dict(zip(verdicts["statement"], verdicts["verdict"], strict=True))
    assert of["error_printed_twice"] == "contradicted"
    assert of["smaller_is_enough"] == "not checkable"
    assert of["overcharge_shows_4c"] == "calibrated"
    assert sum(word != "not checkable" for word in of.values()) >= 15


@pytest.mark.parametrize("step", ["surface", "network", "network_size", "network_kernels", "charge", "trade_off"])
def test_a_step_opens_only_what_it_declared(step: str, made: tuple[Project, Path, Path], tmp_path: Path) -> None:
    opens_only_what_it_declared(made[0], step, tmp_path)


def test_an_ordinary_number_for_a_mode_runs_no_network(made: tuple[Project, Path, Path]) -> None:
    """Without a mode that asks for the network, the charges wait for nothing."""
    project, _, _ = made
    printed = project.snakemake("-n", "charges", overrides="study=nicd_grnn modes.run=[constant_4c]")
    assert "select_centres" not in printed
