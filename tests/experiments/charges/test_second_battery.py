"""The second battery in the configuration and in the plan: what it adds, what it touches, how it leaves."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.planning import make_plan
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel.draft import drafts
from pipeline.kernel.experiment import Draft

REMOVED = "~battery@second_battery"
CHARGES = {
    f"{comparison}/{mode}" for comparison in ("same_peak", "same_mean") for mode in ("cc_cv", "cv_pulse", "cv_reflex")
}


@cache
def study(*words: str) -> Any:
    return study_from(compose_tree(words))


@cache
def nodes(*words: str) -> dict[str, Draft]:
    return {node.name: node for node in drafts(study(*words))}


def keys(*words: str) -> dict[str, str]:
    plan = make_plan([words])
    return {name: node["key"] for name, node in plan["runs"][0]["nodes"].items()}


def test_it_is_charged_like_the_first():
    made = nodes()
    assert {name for name in made if name.startswith("second_charge/")} == {f"second_charge/{one}" for one in CHARGES}
    for one in CHARGES:
        first, second = made[f"charge/{one}"], made[f"second_charge/{one}"]
        assert second.inputs == first.inputs
        assert second.settings["battery"]["name"] == "lead_acid_generic"
        assert {part: second.settings[part] for part in ("mode", "engine")} == {
            part: first.settings[part] for part in ("mode", "engine")
        }
        assert second.settings["charge"] == first.settings["charge"] | {"windows": []}
        assert second.shown["summary.parquet"] == f"second/charge/{one}.summary.parquet"


def test_a_rate_is_one_of_its_own_capacity():
    words = (
        "~modes.cc_cv.max_current_a",
        "+modes.cc_cv.max_current_c_rate=0.3",
        "+modes.cc_cv.sources.max_current_c_rate={kind: estimate}",
        "~modes.cc_cv.sources.max_current_a",
    )
    made = nodes(*words)
    raised = [made[f"{kind}/same_mean/cv_pulse"].settings["mode"]["charge_a"] for kind in ("charge", "second_charge")]
    assert raised == pytest.approx([0.3 * 7.0 / 0.9, 0.3 * 7.29167 / 0.9])


def test_removed_it_leaves_nothing_behind():
    without, usual = nodes(REMOVED), nodes()
    assert study(REMOVED).second_battery is None
    gone = usual.keys() - without.keys()
    assert gone == {f"second_charge/{one}" for one in CHARGES} | {"figure/two_cells"}
    assert not any("second" in name for node in without.values() for name in node.inputs)
    assert "second.parquet" not in without["verdicts"].shown
    assert not any(entry["path"].startswith("second_battery") for entry in without["page"].settings["parameters"])


def test_removing_it_leaves_the_sources_of_the_first_alone():
    sources = study(REMOVED).sources
    assert {source.kind for path, source in sources.items() if path.startswith("battery.")} == {"estimate", "published"}


def test_another_takes_its_place():
    made = nodes("battery@second_battery=lead_acid_12v18ah")
    assert made["second_charge/same_peak/cc_cv"].settings["battery"]["scaled_to_capacity_ah"] == 18.0
    assert made["charge/same_peak/cc_cv"].settings == nodes()["charge/same_peak/cc_cv"].settings


def test_its_parameters_have_sources_on_the_page():
    listed = {entry["path"]: entry["kind"] for entry in nodes()["page"].settings["parameters"]}
    assert listed["second_battery.hysteresis.amplitude_v"] == "estimate"
    changed = study("second_battery.hysteresis.amplitude_v=0.5").sources
    assert changed["second_battery.hysteresis.amplitude_v"].kind == "override"
    assert changed["battery.capacity_ah"].kind == "published"


def test_as_the_first_it_has_no_second():
    assert study("battery=lead_acid_generic").second_battery is None
    assert "figure/two_cells" not in nodes("battery=lead_acid_generic")


def test_a_change_to_it_reaches_its_charges_and_what_tells_of_them():
    before, after = keys(), keys("second_battery.hysteresis.amplitude_v=0.5")
    changed = {name for name in before if before[name] != after[name]}
    assert changed == {f"second_charge/{one}" for one in CHARGES} | {"verdicts", "figure/two_cells", "page"}


def test_a_change_to_the_first_leaves_its_charges_alone():
    before, after = keys(), keys("battery.acceptance.resistance_ohm=0.02")
    assert not any(before[name] != after[name] for name in before if name.startswith("second_charge/"))


def test_a_job_takes_charges_of_both():
    plan = make_plan([()])
    jobs = [chunk["nodes"] for chunk in plan["chunks"].values() if chunk["step"] == "charge"]
    batteries = [{plan["nodes"][key]["settings"]["battery"]["name"] for key in job} for job in jobs]
    assert batteries == [{"lead_acid_12v7ah", "lead_acid_generic"}] * 3


def test_a_mode_that_does_not_suit_it_is_refused_by_its_name():
    words = ("modes.cc_cv.voltage_v=12.4", "second_battery.open_circuit_voltage_v.full_v=14")
    with pytest.raises(
        UserError, match=r"modes\.cc_cv\.phases.*12.4 V does not charge.*second battery, lead_acid_generic"
    ):
        study(*words)


def test_a_battery_that_is_not_there_is_refused_by_the_word_that_asked_for_it():
    with pytest.raises(UserError, match=r"override battery@second_battery=lead: no conf/battery/lead.yaml; "):
        study("battery@second_battery=lead")


def test_a_value_calibrated_in_the_second_reaches_the_verdict_on_it_alone():
    composed = compose_tree([])
    source = {"kind": "calibrated", "ref": "fit", "to": "solar_reflex.pulse_cooler_same_mean"}
    composed.tree["second_battery"]["sources"]["series_resistance_ohm"] = source
    settings = {node.name: node for node in drafts(study_from(composed))}["verdicts"].settings
    assert settings["second_calibrated"] == {"pulse_cooler_same_mean": ["second_battery.series_resistance_ohm"]}
    assert "pulse_cooler_same_mean" not in settings["calibrated"]


def test_points_that_a_table_leaves_out_are_told_when_planned():
    words = ("study=lfp_cuckoo", "battery.entropic_coefficient_v_k.soc=[-0.05,0.1,0.2,0.3,0.4,0.5,0.75,1.1]")
    told = make_plan([words])["runs"][0]["remarks"]
    cut = [line for line in told if line.startswith("battery.entropic")]
    assert cut == [
        "battery.entropic_coefficient_v_k.soc: SOC -0.05, 1.1 lies outside 0 to 1 and is left out; "
        "the edges are interpolated"
    ]
