"""The study of staged charges in the configuration: its nodes, their edges, and what is refused."""

from __future__ import annotations

from functools import cache

import pytest

from pipeline.charge.protocol import resolve
from pipeline.config.compose import compose_tree
from pipeline.config.planning import make_plan
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.experiments.staging.choices import finds, plan_of
from pipeline.kernel.draft import drafts
from pipeline.kernel.experiment import Draft

LFP = "study=lfp_cuckoo"


@cache
def nodes(*words: str) -> dict[str, Draft]:
    return {node.name: node for node in drafts(study_from(compose_tree([LFP, *words])))}


def keys(*words: str) -> dict[str, str]:
    return {name: node["key"] for name, node in make_plan([[LFP, *words]])["runs"][0]["nodes"].items()}


def test_the_plan_is_the_printed_mode():
    study = study_from(compose_tree([LFP]))
    plan = plan_of(study)
    assert plan.currents_a == [39.2, 36.6, 29.8, 14.3, 12.9, 11.8, 8.5, 9.7]
    assert plan.soc_edges == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
    assert (plan.voltage_v, plan.temperature_c, plan.ambient_c) == (3.65, 60.0, 25.0)
    assert {"found_currents_a", "same_peak_currents_a", "constant_same_time_a"} <= set(finds(study)["staging"])


def test_every_search_runs_with_the_first_weights_and_the_one_that_is_used_with_all():
    made = [name for name in nodes() if name.startswith("staging_search/")]
    first = [name for name in made if "/weights_5_5/" in name]
    assert len(first) == len(study_from(compose_tree([LFP])).staging.searches)
    assert {name for name in made if name not in first} == {
        "staging_search/weights_3_7/integral",
        "staging_search/weights_7_3/integral",
    }
    assert set(nodes()["staging"].inputs) == set(made)


def test_charges_ask_for_what_is_found():
    made = nodes()
    for mode in ("staged_found", "staged_same_peak", "staged_same_final", "constant_same_time", "cc_cv_same_peak"):
        assert made[f"charge/charges/{mode}"].inputs["staging"] == "staging"
    assert "staging" not in made["charge/charges/staged_printed"].inputs
    staged = made["charge/charges/staged_found"].settings["mode"]["phases"]["stages"]["staged"]
    assert staged["currents_a"] == {"from": "staging", "value": "found_currents_a"}
    assert not any("supply" in node.inputs for node in made.values())
    assert {"panel", "supply", "tuning", "search", "ensemble/search"}.isdisjoint(made)


def test_currents_that_are_not_yet_found_are_said_to_be_missing():
    study = study_from(compose_tree([LFP]))
    with pytest.raises(UserError, match=r"phases\.stages\.currents_a: still to be found by 'staging'"):
        resolve(study.modes["staged_found"], study.battery.capacity_in_use_ah)


def test_calibrations_reach_the_front_alone():
    before, after = keys(), keys("calibrations.half_entropy.thermal.heat_capacity_j_k=210")
    changed = {name for name in before if before[name] != after[name]}
    assert "front" in changed
    assert not any(name.startswith(("staging", "charge/", "functions")) for name in changed)


def test_titles_compute_nothing():
    before = keys()
    after = keys("battery.title=Another", "staging.title=Another")
    assert all(before[name] == after[name] for name in before if name.startswith(("staging", "front", "charge/")))


def test_the_measured_capacity_is_an_option():
    assert study_from(compose_tree([LFP, "battery=lfp_8ah_measured"])).battery.capacity_ah == 7.90


@pytest.mark.parametrize("name", ["half_entropy", "no_entropy", "no_entropy_heavy"])
def test_every_calibration_is_a_battery_and_says_what_it_was_calibrated_to(name):
    study = study_from(compose_tree([LFP, f"battery=lfp_8ah_{name}"]))
    assert study.battery == study.calibrations[name]
    for part in ("series_resistance_ohm.scale", "thermal.heat_capacity_j_k", "entropic_coefficient_v_k.scale"):
        assert study.sources[f"battery.{part}"].to == "lfp_cuckoo.temperature_rise"


def test_calibrated_statements_are_marked():
    assert set(nodes()["verdicts"].settings["calibrated"]) == {"temperature_rise", "simulated_rise_at_the_end"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["staging.mode=cc_cv_5c"], "staging.mode: 'cc_cv_5c' has no staged phase"),
        (["staging.mode=staged_printd"], "staging.mode: no mode 'staged_printd'.*staged_printed"),
        (["staging.mode=staged_found"], "staging.mode: 'staged_found' has values that are still to be found"),
        (["staging.use=pi"], r"staging.*use is 'pi', which is no search"),
        (["staging.rise=sum"], r"staging\.rise.*'final'"),
        (["staging.current_a.low=41"], r"low is 41; it must lie below high, 40"),
        (["staging.weights.weights_5_5.rise=0"], r"staging\.weights\.weights_5_5\.rise"),
        (["staging.searches.plain.nests=1"], r"staging\.searches\.plain\.nests.*greater than or equal to 3"),
        (["staging.searches.plain.kind=cukoo"], r"staging\.searches\.plain\..*no search algorithm 'cukoo'.*cuckoo"),
        (["+staging.searches.plain.title=x"], r"searches\.plain\.title: all searches look in the same box"),
        (
            ["~staging.searches.plain", "+staging.searches.plain={kind:sweep,points:9,refinements:0}"],
            r"staging\.searches\.plain: points is 9 along each of 8 variables",
        ),
        (["battery=nicd_2s_600mah"], r"battery\.(side_reaction|charge_transfer).*alone"),
        (["charge.initial_soc=0.25"], r"charge\.initial_soc: 0\.25 lies beyond the first stage"),
        (
            ["modes.staged_found.phases.stages.staged.currents_a={from:staging,value:found_current_a}"],
            "staging finds no 'found_current_a'.*found_currents_a",
        ),
        (
            ["modes.staged_found.phases.stages.staged.soc_edges=[0.3,0.6,0.9]"],
            r"modes\.staged_found\.phases\.stages\.staged\.soc_edges: 3 edges, but the stages.*are 8",
        ),
        (["published.charging_time.check.close.value=printed_times_s of staging.quantities"], "nothing called"),
    ],
)
def test_a_mistake_is_named(words, message):
    with pytest.raises(UserError, match=message):
        study_from(compose_tree([LFP, *words]))


def test_another_number_of_stages_needs_a_mode_alone():
    words = [
        "modes.staged_printed.phases.stages.staged.currents_a=[30,20,10]",
        "modes.staged_printed.phases.stages.staged.soc_edges=[0.3,0.6,0.9]",
        "modes.run=[staged_printed]",
    ]
    made = nodes(*words)
    assert made["staging"].settings["problem"]["plan"]["soc_edges"] == [0.1, 0.3, 0.6, 0.9]
    assert len(made["staging_search/weights_5_5/plain"].settings["search"]["variables"]) == 3


def test_a_study_is_made_without_the_others():
    plan = make_plan([[LFP], ["study=solar_reflex"]])
    run = next(run for run in plan["runs"] if run["study"] == "lfp_cuckoo" and not run["overrides"][1:])
    own = {node["key"] for node in run["nodes"].values()}
    waiting, needed = list(plan["targets"]["lfp_cuckoo"]), set()
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting.extend(plan["chunks"][name]["needs"])
    assert own == {key for name in needed for key in plan["chunks"][name].get("nodes", ())}
    assert set(plan["targets"]["lfp_cuckoo"]) < set(plan["targets"]["all"])
