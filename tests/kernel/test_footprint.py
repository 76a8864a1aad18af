"""What jobs are to be given: from the effort of their nodes, above what was measured, and part of no key."""

from __future__ import annotations

import json
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from pipeline.config.planning import make_plan
from pipeline.config.sweep import asked, make_sweep
from pipeline.kernel import registry
from pipeline.kernel.draft import reached
from pipeline.kernel.experiment import Effort
from pipeline.kernel.footprint import LEAST_MINUTES, MEMORY_MARGIN, TIME_MARGIN, Footprint, of_step, resources
from tests.slurm.measured import TABLE

MEASURED = json.loads(TABLE.read_text(encoding="utf-8"))


def _sweep(*words: str) -> dict[str, Any]:
    own, wanted = asked(["modes.run=[cc_cv]", "modes.cc_cv.max_current_a=1,1.5,2,2.5,3,3.5", *words])
    return make_sweep(own, wanted, 1)


def test_memory_is_of_the_largest_nodes_at_once_and_time_of_all() -> None:
    footprint = Footprint(memory_mb=300.0, start_s=10.0, node_s=2.0, together=2)
    efforts = [Effort(1e9, 600.0, ("a",)), Effort(2e9, 0.5, ("a",)), Effort(4e9, 1200.0, ("a",)), None]
    given = resources(footprint, efforts)
    assert given["mem_mb"] == 50 * -(-MEMORY_MARGIN * (300.0 + 4000.0 + 2000.0) // 50.0)
    assert given["runtime"] == -(-TIME_MARGIN * (10.0 + 600.0 + 2.0 + 1200.0 + 2.0) // 60.0)
    assert given["threads"] == 1


def test_a_short_job_is_given_the_least() -> None:
    assert resources(Footprint(), [None])["runtime"] == LEAST_MINUTES


@pytest.mark.parametrize("study", ["solar_reflex", "lfp_cuckoo", "nicd_grnn"])
def test_jobs_are_given_more_than_the_largest_of_their_step_took(study: str) -> None:
    plan = make_plan([[f"study={study}"]])
    chunks = plan["chunks"]
    wrong = []
    for name in reached(plan["targets"]["all"], lambda chunk: chunks[chunk]["needs"]):
        took, given = MEASURED[chunks[name]["step"]], chunks[name]["resources"]
        if given["mem_mb"] < 1.05 * took["memory_mb"] or 60.0 * given["runtime"] < 2.0 * took["time_s"]:
            wrong.append(f"{name}: {given} is less than {took} with a margin")
        if given["mem_mb"] > 500.0 + 3.0 * took["memory_mb"]:
            wrong.append(f"{name}: {given} leaves no room for others beside {took}")
    assert not wrong


def test_a_step_that_batches_says_how_many_nodes_it_holds() -> None:
    for name, step in registry.steps().items():
        spec = find_spec(registry.module(name))
        assert spec is not None
        assert spec.origin is not None
        batches = "\ndef run_many(" in Path(spec.origin).read_text(encoding="utf-8")
        assert of_step(step).together == (import_module(registry.module(name)).BATCH if batches else 1)


def test_a_larger_configuration_is_given_more() -> None:
    given = []
    for words in ([], ["network.data.grid.gradients=1000"]):
        chunks = make_plan([["study=nicd_grnn", *words]])["chunks"].values()
        given += [chunk["resources"]["runtime"] for chunk in chunks if chunk["step"] == "network"]
    assert given[1] > 10 * given[0]


def test_what_a_job_is_given_is_part_of_no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    before = make_plan([["study=nicd_grnn"]])
    monkeypatch.setattr("pipeline.kernel.footprint.MEMORY_MARGIN", 3.0)
    after = make_plan([["study=nicd_grnn"]])
    assert after["nodes"] == before["nodes"]
    assert after["chunks"].keys() == before["chunks"].keys()
    assert after["chunks"] != before["chunks"]


def _charged(*words: str) -> list[int]:
    return [len(chunk["nodes"]) for chunk in _sweep(*words)["chunks"].values() if chunk["step"] == "charge"]


def test_jobs_of_a_sweep_hold_at_least_the_work_that_is_asked_for() -> None:
    # Six charges of 0.015 s each, by their footprint.
    assert _charged() == [3, 3]
    assert _charged("sweep.job_s=0.05") == [3, 3]
    assert _charged("sweep.job_s=0.085") == [6]
    assert _charged("sweep.job_s=30") == [6]
    assert set(_sweep()["nodes"]) == set(_sweep("sweep.job_s=30")["nodes"])
