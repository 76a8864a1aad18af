"""The steps of a search for stage currents, from settings to artefacts, in small."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.experiments.staging import staging_search
from pipeline.experiments.staging.choices import fields, finds
from pipeline.kernel import registry
from tests.experiments.staging.staging_world import SEARCHED, make, nodes, small
from tests.making import inputs, output


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("staging")
    make(folder, SEARCHED)
    return folder


def table(made: Path, node: str, name: str):
    return inputs({node: made / node}).table(node, name)


def numbers(made: Path, step: str) -> dict[str, float]:
    found = table(made, step, "quantities")
    return dict(zip(found["quantity"].tolist(), found["value"].tolist(), strict=True))


@pytest.mark.parametrize("step", ["staging", "front"])
def test_the_numbers_are_those_that_statements_may_name(made, step):
    declared = registry.steps()[step].quantities
    assert set(numbers(made, step)) == declared.names(fields(small())[step])
    assert all(np.isfinite(value) for value in numbers(made, step).values())


def test_what_is_found_is_what_modes_may_ask_for(made):
    found = json.loads((made / "staging" / "found.json").read_text())
    assert set(found) == set(finds(small())["staging"])
    currents = table(made, "staging", "currents")
    for name, case in (("found", "weights_5_5"), ("same_peak", "same_peak"), ("same_final", "same_final")):
        rows = currents["case"] == case
        np.testing.assert_array_equal(currents["current_a"][rows], found[f"{name}_currents_a"])


def test_runs_are_cut_at_the_compared_number_of_charges(made):
    runs = table(made, "staging_search/weights_5_5/plain", "runs")
    assert runs["evaluations"].tolist() == [490] * 3
    assert runs["early_evaluations"].tolist() == [50] * 3
    assert np.all(runs["value"] <= runs["early_value"])
    course = table(made, "staging_search/weights_5_5/plain", "course")
    assert np.all(np.diff(course["median"]) <= 0.0)
    assert np.all((course["low"] <= course["median"]) & (course["median"] <= course["high"]))


def test_the_same_settings_give_the_same_search(made, tmp_path):
    node = next(node for node in nodes() if node.name == "staging_search/weights_5_5/integral")
    staging_search.run(node.settings, inputs({}), output("staging_search", tmp_path))
    for name in ("runs", "run_currents", "course"):
        first = made / node.name / f"{name}.parquet"
        assert first.read_bytes() == (tmp_path / f"{name}.parquet").read_bytes()


def test_no_search_ends_below_the_best_there_is(made):
    found = numbers(made, "staging")
    for name in ("plain", "integral", "swarm"):
        assert found[f"{name}_excess_mean"] >= 0.0
        assert found[f"{name}_excess_worst"] >= found[f"{name}_excess_mean"]
    assert found["weights_5_5_value"] >= found["weights_5_5_best_value"] * (1.0 - 1e-9)
    assert found["weights_5_5_agreeing_share"] == 1.0
    assert found["time_integral_over_plain"] == pytest.approx(
        found["integral_time_mean_s"] / found["plain_time_mean_s"], rel=1e-12
    )


def test_the_printed_currents_lose_under_every_calibration(made):
    found = numbers(made, "front")
    for name in small().calibrations:
        assert found[f"{name}_same_peak_share"] > 0.10
        assert found[f"{name}_same_final_share"] > 0.05
        assert found[f"{name}_printed_peak_k"] == pytest.approx(4.0, abs=0.1)
        assert found[f"{name}_rise_after_stage_3_k"] == pytest.approx(3.5, abs=0.1)
    assert found["least_same_final_share"] == min(found[f"{name}_same_final_share"] for name in small().calibrations)
    # Our full calibration is the study's own battery.
    assert found["full_entropy_same_peak_s"] == pytest.approx(numbers(made, "staging")["same_peak_s"], rel=1e-9)
