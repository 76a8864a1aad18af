"""Composition: what a configuration becomes, and where each value came from."""

from __future__ import annotations

import json
import re
import shutil
from functools import cache
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from pipeline.config.compose import compose_tree, expand, options
from pipeline.config.inheritance import CONF
from pipeline.config.sources import split
from pipeline.config.study import study_from
from pipeline.errors import UserError


def test_an_override_reaches_its_record_and_is_its_source() -> None:
    study = study_from(compose_tree(["battery.thermal.resistance_k_w=2.5"]))
    assert study.battery.thermal.resistance_k_w == 2.5
    source = study.sources["battery.thermal.resistance_k_w"]
    assert (source.kind, source.ref) == ("override", "battery.thermal.resistance_k_w=2.5")
    assert study.sources["battery.thermal.heat_capacity_j_k"].kind != "override"


def test_a_choice_of_group_is_no_override_of_its_values() -> None:
    study = study_from(compose_tree(["battery=lead_acid_12v18ah"]))
    assert study.battery.capacity_in_use_ah == 18
    assert study.sources["battery.thermal.resistance_k_w"].kind != "override"


def test_every_parameter_has_a_source() -> None:
    study = study_from(compose_tree([]))
    named = {path for section in study.parameter_sections() for path, _ in study.parameters(section)}
    assert named == set(study.sources)
    assert len(named) > 40


def test_a_missing_source_names_file_and_key() -> None:
    composed = compose_tree([])
    del composed.tree["battery"]["sources"]["capacity_ah"]
    with pytest.raises(UserError, match=r"conf/battery/lead_acid_12v7ah\.yaml:\d+: battery\.capacity_ah = 7"):
        study_from(composed)


def test_a_source_of_nothing_is_refused() -> None:
    composed = compose_tree([])
    composed.tree["battery"]["sources"]["capacty_ah"] = {"kind": "estimate"}
    with pytest.raises(UserError, match="capacity_ah"):
        study_from(composed)


def test_a_calibrated_value_says_to_what() -> None:
    composed = compose_tree([])
    composed.tree["battery"]["sources"]["capacity_ah"] = {"kind": "calibrated"}
    with pytest.raises(UserError, match="which published statement"):
        study_from(composed)


def test_origins_name_file_and_line() -> None:
    composed = compose_tree(["panel.cells_in_series=40"])
    assert composed.origin("panel.cells_in_series") == "override panel.cells_in_series=40"
    assert composed.origin("panel.max_power_w").startswith("conf/panel/kc65t.yaml:")
    assert composed.origin("charge.initial_soc").startswith("conf/study/solar_reflex.yaml:")
    assert composed.origin("seed").startswith("conf/config.yaml:")


def test_a_scaled_battery_names_the_file_that_holds_the_value() -> None:
    composed = compose_tree(["battery=lead_acid_12v18ah"])
    assert composed.origin("battery.scaled_to_capacity_ah").startswith("conf/battery/lead_acid_12v18ah.yaml:")
    assert composed.origin("battery.thermal.resistance_k_w").startswith("conf/battery/lead_acid_12v7ah.yaml:")


@pytest.mark.parametrize(
    "words",
    [
        *([f"study={study}"] for study in options("study")),
        ["battery=lead_acid_12v18ah", "battery.thermal.resistance_k_w=2.5", "~converter.switched", "~design"],
        ["weather=half_cloudy_taichung", "+weather.clouds.note=thin", "modes.cv_reflex.frequency_hz=50"],
        ["study=lfp_cuckoo", "functions=full"],
    ],
)
def test_files_are_merged_as_hydra_merges_them(words: list[str]) -> None:
    modes = [f"+modes@modes.{name}={name}" for name in options("modes")]
    with initialize_config_dir(str(CONF), version_base="1.3"):
        whole = OmegaConf.to_container(compose("config", overrides=[*modes, *words]), resolve=True)
    assert isinstance(whole, dict)
    ours = compose_tree(words).tree
    assert json.dumps(split(ours)[0]) == json.dumps(split(whole)[0])  # also in the same order


def test_an_edited_file_is_read_again(tmp_path: Path) -> None:
    conf = Path(shutil.copytree(CONF, tmp_path / "conf"))
    for capacity in (7.5, 8.25):
        file = conf / "battery" / "lead_acid_12v7ah.yaml"
        file.write_text(re.sub(r"capacity_ah: [\d.]+", f"capacity_ah: {capacity}", file.read_text(), count=1))
        assert compose_tree([], conf).tree["battery"]["capacity_ah"] == capacity


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("day=null", "override day=null: a group is left out with ~day"),
        ("battery@second_battery=null", "a group is left out with ~battery@second_battery"),
        ("~dy", "override ~dy: the configuration has no key 'dy'; best matches are: day"),
        ("~functions", "override ~functions: this study has no functions; it has: answer, battery, "),
        ("~modes.cc_cv.volts_v", "override ~modes.cc_cv.volts_v: modes.cc_cv has no key 'volts_v'; .* voltage_v"),
    ],
)
def test_what_is_not_there_cannot_be_left_out(word: str, told: str) -> None:
    with pytest.raises(UserError, match=told):
        compose_tree([word])


def test_the_keys_of_a_group_put_elsewhere_are_known() -> None:
    words = ["weather@day.weathers.clear=measured", "day.weathers.clear.colums={ghi: G}"]
    with pytest.raises(UserError, match=r"day\.weathers\.clear has no key 'colums'; best matches are: columns"):
        compose_tree(words)
    with pytest.raises(
        UserError, match=r"units=\{time: min\}: day\.weathers\.clear\.units has no key 'time'; .*time_s"
    ):
        compose_tree([words[0], "day.weathers.clear.units={time: min}"])


def test_several_values_are_no_run() -> None:
    for word in ("battery.capacity_ah=7,8", "battery=lfp_8ah,lead_acid_12v7ah"):
        with pytest.raises(UserError, match=f"override {word}: several values make a sweep"):
            compose_tree([word])


def test_sweeps_expand_as_hydras_do() -> None:
    runs = expand(["battery=a,b", "seed=range(1,3)", "charge.initial_soc=0.3"])
    assert len(runs) == 4
    assert runs[0] == ["battery=a", "seed=1", "charge.initial_soc=0.3"]


@pytest.mark.parametrize("name", options("battery"))
def test_every_battery_composes(name: str) -> None:
    owner = {"lfp": "lfp_cuckoo", "nmc": "lfp_cuckoo", "nicd": "nicd_grnn"}.get(name.split("_")[0], "solar_reflex")
    study = study_from(compose_tree([f"study={owner}", f"battery={name}"]))
    assert study.battery.name == name


def test_a_battery_is_not_charged_at_the_voltage_of_another() -> None:
    with pytest.raises(UserError, match=r"voltage_v: 14.4 V .* rests at 3.43 V when full; allowed is 1.43 to 6.86 V"):
        study_from(compose_tree(["battery=lfp_8ah"]))


@cache
def runs_of_studies() -> dict[str, list[str]]:
    return {study: compose_tree([f"study={study}"]).tree["modes"]["run"] for study in options("study")}


@pytest.mark.parametrize("name", options("modes"))
def test_every_mode_composes(name: str) -> None:
    owner = next((study for study, run in runs_of_studies().items() if name in run), "solar_reflex")
    if name.endswith(("_nmc", "_lifepo4")):
        cell = "nmc_5ah" if name.endswith("_nmc") else "lfp_8ah"
        assert study_from(compose_tree(["study=lfp_cuckoo", f"battery={cell}", f"modes.run=[staged_found,{name}]"]))
        return
    run = f"cc_cv,{name}" if owner == "solar_reflex" and name != "cc_cv" else name
    assert study_from(compose_tree([f"study={owner}", f"modes.run=[{run}]"]))
