"""What Snakemake hands on is read as it was typed."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from snakemake.cli import parse_config

from pipeline.commands.workflow import BESIDE_MB, Workflow, as_typed, split_overrides
from pipeline.kernel import planfile
from tests.faults import instant

WORDS = st.lists(st.text(st.characters(codec="ascii", exclude_categories=["Cc"]), min_size=1), min_size=2, max_size=4)


@given(WORDS)
def test_words_come_through_snakemake_as_they_were_typed(words: list[str]) -> None:
    typed = f"overrides=study=x {shlex.join(words)}"
    handed_on = str(parse_config([typed])["overrides"])
    assert split_overrides(as_typed(handed_on, ["snakemake", "all", "--config", typed])) == ["study=x", *words]


@pytest.mark.parametrize("typed", [[], ["snakemake", "--config", "plan=x"], ["overrides"]])
def test_what_was_not_typed_stays_as_it_is(typed: list[str]) -> None:
    assert as_typed("study=x 'a b' c", typed) == "study=x 'a b' c"


@pytest.fixture
def flow(tmp_path: Path) -> Workflow:
    plan = instant.plan()
    for chunk in plan["chunks"].values():
        chunk["resources"] = {"threads": 1, "mem_mb": 500, "runtime": 10}
    file = planfile.save(plan, tmp_path / "results")
    return Workflow({"plan": str(file)}, tmp_path / "results", purpose="job")


def test_a_job_that_is_tried_again_is_given_twice_as_much(flow: Workflow) -> None:
    assert [flow.takes("first-50", "mem_mb", attempt) for attempt in (1, 2, 3)] == [500, 1000, 2000]
    assert [flow.takes("first-50", "runtime", attempt) for attempt in (1, 2)] == [10, 20]
    assert flow.takes("first-50", "threads", 2) == 1


def test_a_job_elsewhere_has_room_for_what_runs_it(flow: Workflow) -> None:
    assert flow.takes("first-50", "mem_mb", elsewhere=True) == 500 + BESIDE_MB
    assert flow.takes("first-50", "runtime", elsewhere=True) == 10


def test_jobs_elsewhere_are_handed_the_plan(flow: Workflow) -> None:
    assert flow.handed_on() == [f"plan={flow.file}", "tell=false"]


def test_what_is_carried_is_taken_and_given(flow: Workflow) -> None:
    (receipt,) = flow.needs("second-50")
    archive = str(flow.results / "archives" / "first" / "first-50.tar")
    assert flow.needs("second-50", carried=True) == [receipt, archive]
    assert flow.archives("second", carried=False) == []
    assert flow.archives("publish", carried=True) == []
    line = flow.command("second", "second-50", take=["a b.json", "a.tar"], give=["c.json"])
    assert "--take 'a b.json' a.tar --give c.json >" in line
    assert "--take" not in flow.command("second", "second-50")
