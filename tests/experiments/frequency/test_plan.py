"""The plan's edges from what is found to what asks for it, and nodes that nothing asks for."""

from __future__ import annotations

from functools import cache

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.planning import make_plan
from pipeline.config.study import study_from
from pipeline.kernel.draft import drafts
from pipeline.kernel.experiment import Draft


@cache
def nodes(*words: str) -> dict[str, Draft]:
    return {node.name: node for node in drafts(study_from(compose_tree(words)))}


def keys(*words: str) -> dict[str, str]:
    plan = make_plan([words])
    return {name: node["key"] for name, node in plan["runs"][0]["nodes"].items()}


def test_each_reference_is_an_edge():
    made = nodes()
    assert made["search"].inputs == {"tuning": "tuning"}
    assert made["tuning"].inputs == {}
    for comparison in ("same_peak", "same_mean"):
        assert made[f"charge/{comparison}/cv_reflex"].inputs["search"] == "search"
        assert made[f"charge/{comparison}/cv_pulse"].inputs["search"] == "search"
        assert "search" not in made[f"charge/{comparison}/cc_cv"].inputs
    assert made["figure/figure_4_reflex_intervals"].inputs == {"search": "search"}
    assert "search" not in made["figure/panel_curves"].inputs
    assert made["ensemble/charge"].inputs["search"] == "search"
    assert "search" not in made["ensemble/objective"].inputs


def test_a_number_takes_search_and_tuning_out():
    made = nodes("modes.cv_reflex.frequency_hz=50")
    assert {"search", "tuning"}.isdisjoint(made)
    assert {"chaos", "objective"} <= set(made)
    assert not any({"search", "tuning"} & set(node.inputs.values()) for node in made.values())
    listed = {entry["path"] for entry in made["page"].settings["parameters"]}
    assert not any(path.startswith(("search.", "design.", "oracle.")) for path in listed)


def test_known_constants_take_the_tuning_out_alone():
    made = nodes("search.c1=1", "search.c2=1", "search.w=0.75")
    assert "tuning" not in made
    assert made["search"].inputs == {}


def test_one_mode_that_still_asks_keeps_the_search():
    assert "search" in nodes("modes.cv_pulse.frequency_hz=20")
    assert "search" not in nodes("modes.run=[cc_cv]")


def test_a_figure_of_a_step_that_is_left_out_is_not_drawn():
    assert "figure/figure_9_frequency_convergence" in nodes()
    without = nodes("modes.cv_reflex.frequency_hz=50")
    assert "figure/figure_9_frequency_convergence" not in without
    assert "figure_9_frequency_convergence" not in {card["name"] for card in without["page"].settings["figures"]}
    assert "figure/panel_curves" in without


def test_what_was_calibrated_reaches_the_verdict_through_the_search():
    calibrated = nodes()["verdicts"].settings["calibrated"]
    assert calibrated["frequency_converges_at_90_hz"] == ["objective.transistor.fall_time_s"]
    assert calibrated["ise_converges_at_0_2"] == ["objective.window_s"]


@pytest.mark.parametrize(
    ("word", "changed"),
    [
        ("battery.thermal.heat_capacity_j_k=2150", set()),
        ("battery.pairs.fast.time_constant_s=0.007", {"objective", "tuning", "search"}),
        ("objective.band_share=0.02", {"objective"}),
        ("objective.window_s=0.8", {"objective", "tuning", "search"}),
        ("search.title=swarming", set()),
        ("search.replicates=20", {"search"}),
        ("search.particles=12", {"tuning", "search"}),
        ("design.replicates=20", {"tuning", "search"}),
        ("chaos.start=0.6", {"chaos"}),
        ("seed=1", {"tuning", "search"}),
    ],
)
def test_a_change_reaches_the_steps_it_concerns(word, changed):
    finders = {"chaos", "objective", "tuning", "search"}
    before, after = keys(), keys(word)
    assert {name for name in finders if before[name] != after[name]} == changed


def test_the_algorithm_is_part_of_the_key():
    assert nodes()["search"].modules == ("pipeline.search.algorithms.swarm", "pipeline.search.algorithms.sweep")
    assert nodes("search=sweep")["search"].modules == ("pipeline.search.algorithms.sweep",)


def test_the_targets_hold_their_steps():
    plan = make_plan([[]])
    steps = {name: chunk["steps"] for name, chunk in plan["chunks"].items() if chunk["step"] == "publish"}
    assert [steps[name] for name in plan["targets"]["tuning"]] == [["tuning"]]
    assert [sorted(steps[name]) for name in plan["targets"]["search"]] == [["chaos", "objective", "search"]]
