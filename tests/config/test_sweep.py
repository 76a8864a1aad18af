"""The plan of a sweep: its nodes are those of its runs made alone, under names that are good names of folders."""

from __future__ import annotations

import re
import shlex
from typing import Any

import pytest

from pipeline.config import naming
from pipeline.config.compose import compose_tree
from pipeline.config.planning import run_of
from pipeline.config.sweep import Asked, asked, make_sweep
from pipeline.errors import UserError
from pipeline.kernel import planfile

WORDS = ["battery=lead_acid_12v7ah,lead_acid_12v18ah", "modes.cv_reflex.frequency_hz=10,50"]
RUN = "battery=lead_acid_12v18ah__cv_reflex.frequency_hz=50"


@pytest.fixture(scope="module")
def plan() -> dict[str, Any]:
    return make_sweep(WORDS, Asked("two"), 2)


def test_nodes_are_those_of_the_run_alone(plan: dict[str, Any]) -> None:
    alone = run_of(["battery=lead_acid_12v18ah", "modes.cv_reflex.frequency_hz=50"])
    by_name = {node.name: node for node in alone.nodes}
    mine = {
        name.removeprefix(f"{RUN}/"): node["key"]
        for name, node in plan["runs"][0]["nodes"].items()
        if name.startswith(f"{RUN}/")
    }
    assert mine == {name: key for name, key in alone.keys.items() if name.startswith("charge/")}
    for name, key in mine.items():
        assert planfile.settings(plan, key) == by_name[name].settings


def test_what_is_common_to_runs_is_planned_once(plan: dict[str, Any]) -> None:
    steps = [node["step"] for node in plan["nodes"].values()]
    # A constant current of each battery; pulses of each battery and frequency; each at two comparisons.
    assert steps.count("charge") == 2 + 2 * 2 * 2 * 2
    assert {step: steps.count(step) for step in ("panel", "supply", "engine", "sweep")} == {
        "panel": 1,
        "supply": 1,
        "engine": 1,
        "sweep": 1,
    }


def test_statements_that_summaries_of_charges_answer_are_asked_of_every_run(plan: dict[str, Any]) -> None:
    names = {one["name"] for one in plan["nodes"][plan["runs"][0]["nodes"]["sweep"]["key"]]["settings"]["statements"]}
    assert {"cc_cv_fastest_same_peak", "reflex_cooler_same_mean"} <= names
    assert "frequency_converges_at_90_hz" not in names


def test_charges_are_at_least_twice_as_many_jobs_as_cores(plan: dict[str, Any]) -> None:
    jobs = [chunk for chunk in plan["chunks"].values() if chunk["step"] == "charge"]
    assert len(jobs) >= 4
    assert max(len(job["nodes"]) for job in jobs) <= 2 * min(len(job["nodes"]) for job in jobs)


def test_a_run_is_kept_as_its_difference(plan: dict[str, Any]) -> None:
    assert list(plan["runs"][0]["sweep"]) == [
        f"battery={battery}__cv_reflex.frequency_hz={frequency}"
        for battery in ("lead_acid_12v7ah", "lead_acid_12v18ah")
        for frequency in (10, 50)
    ]
    one = plan["runs"][0]["sweep"][RUN]
    assert one["values"] == ["lead_acid_12v18ah", 50]
    assert one["overrides"] == ["battery=lead_acid_12v18ah", "modes.cv_reflex.frequency_hz=50"]


@pytest.mark.parametrize(
    ("word", "keep", "kinds"),
    [
        ("modes.cc_cv.max_current_a=1,2", (), {"charge"}),
        ("modes.cc_cv.max_current_a=1,2", ("second_charge",), {"charge", "second_charge"}),
        ("battery@second_battery=lead_acid_12v18ah,lead_acid_generic", (), {"charge", "second_charge"}),
    ],
)
def test_the_second_battery_is_charged_where_it_is_asked_for_or_swept(
    word: str, keep: tuple[str, ...], kinds: set[str]
) -> None:
    plan = make_sweep(["modes.run=[cc_cv]", word], Asked(keep=keep), 2)
    nodes = plan["nodes"][plan["runs"][0]["nodes"]["sweep"]["key"]]["inputs"]
    assert {name.split("/")[1] for name in nodes} == kinds


def test_a_study_that_charges_nothing_is_refused() -> None:
    with pytest.raises(UserError, match="study validation: nothing of it is swept"):
        make_sweep(["study=validation", "seed=1,2"], Asked(), 2)


def test_traces_are_shown_in_the_folder_of_each_run_where_they_are_kept(plan: dict[str, Any]) -> None:
    def traces(plan: dict[str, Any]) -> set[str]:
        return {item["place"] for item in plan["runs"][0]["view"] if item["place"].endswith(".bdf.parquet")}

    kept = make_sweep(["modes.run=[cc_cv]", "modes.cc_cv.max_current_a=1,2"], Asked(keep=("traces",)), 2)
    assert traces(plan) == set()
    assert traces(kept) == {
        f"cc_cv.max_current_a={current_a}/charge/{comparison}/cc_cv.bdf.parquet"
        for current_a in (1, 2)
        for comparison in ("same_peak", "same_mean")
    }


def test_words_of_the_sweep_are_taken_out() -> None:
    words, wanted = asked([*WORDS, "sweep.name=mine", "sweep.keep=[traces]"])
    assert words == WORDS
    assert wanted == Asked("mine", ("traces",))
    for word in ("sweep.names=x", "sweep.name='a b'", "sweep.keep=[tracks]"):
        with pytest.raises(UserError, match=re.escape(f"override {word}")):
            asked([word])


def test_the_printed_command_makes_the_same_sweep_again() -> None:
    given = ["modes.run=[cc_cv]", "modes.cc_cv.max_current_a=1,2"]
    own, wanted = asked(["sweep.name=mine", *given, "sweep.keep=[traces]", "sweep.job_s=5"])
    (run,) = make_sweep(own, wanted, 2)["runs"]
    words = shlex.split(run["command"])
    assert words[:4] == ["python", "-m", "pipeline", "-m"]
    # The work of a job changes nothing of what is made.
    assert words[4:] == [*given, "sweep.name=mine", "sweep.keep=[traces]"]
    again, anew = asked(words[4:])
    assert (again, anew.name, anew.keep) == (own, "mine", ("traces",))


def test_names_are_the_shortest_that_tell_keys_apart() -> None:
    tree = compose_tree([]).tree
    keys = ("battery", "modes.cv_reflex.frequency_hz", "charge.initial_soc", "battery@second_battery", "modes.run")
    short = ["battery", "cv_reflex.frequency_hz", "charge.initial_soc", "second_battery", "run"]
    assert list(naming.short(keys, tree).values()) == short


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ([], "default"),
        (["battery=a"], "battery=a"),
        (["modes.run=[cc_cv,cv_reflex]"], "modes.run=cc_cv+cv_reflex"),
        (["modes.cv_reflex.frequency_hz=50", "battery=a"], "battery=a__modes.cv_reflex.frequency_hz=50"),
        (["~battery@second_battery"], "~battery@second_battery"),
        (["+battery.scaled_to_capacity_ah=2.2"], "battery.scaled_to_capacity_ah=2.2"),
        (["measured.file=data/june.csv"], "measured.file=data.june.csv"),
    ],
)
def test_names_of_runs(overrides: list[str], name: str) -> None:
    assert naming.run_name(overrides) == name


@pytest.mark.parametrize("word", ["title='a, b'", "x={a:1,b:[2]}", "x=[a,[b]]", "x=é", "x=" + "long" * 40])
def test_names_of_other_runs_are_told_apart_by_a_digest(word: str) -> None:
    name = naming.run_name([word])
    assert re.fullmatch(r"[A-Za-z0-9_.+=~@-]{1,100}", name)
    assert name != naming.run_name([f"{word}1"])


def test_a_file_named_from_the_root_stands_in_a_name_by_its_last_word() -> None:
    names = [naming.run_name([f"measured.more=[/home/{who}/june.csv, '/home/{who}/my data/july.csv']"]) for who in "ab"]
    assert all(re.fullmatch(r"measured\.more=june\.csv\+july\.csv-[0-9a-f]{8}", name) for name in names)
    assert len(set(names)) == 2


def test_the_work_of_a_job_is_seconds() -> None:
    assert asked(["sweep.job_s=30"])[1].job_s == 30
    for word in ("sweep.job_s=-1", "sweep.job_s=long", "sweep.job_s=true", "sweep.job_s=1e9"):
        with pytest.raises(UserError, match=r"override sweep\.job_s=.*allowed are seconds from 0 to 86400"):
            asked([word])
