"""Files that build on one another: a changed value needs a source of its own, and messages name who changed it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.config.compose import compose_tree
from pipeline.config.inheritance import CONF
from pipeline.config.sources import Source
from pipeline.config.study import study_from
from pipeline.errors import UserError

OWN = {"name": "own", "title": "Own"}
ESTIMATE = {"kind": "estimate", "ref": "as weighed"}


@pytest.fixture(scope="module")
def conf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(CONF, tmp_path_factory.mktemp("project") / "conf"))


def sources(conf: Path, *words: str, base: str = "lead_acid_12v7ah", **content: Any) -> dict[str, Source]:
    """Return the sources of a battery that builds on a shipped one."""
    own = {"defaults": [base, "_self_"], **OWN, **content}
    (conf / "battery" / "own.yaml").write_text(yaml.safe_dump(own, sort_keys=False))
    return study_from(compose_tree(["battery=own", *words], conf)).sources


def test_what_is_not_changed_keeps_its_source(conf: Path) -> None:
    found = sources(conf)
    assert found["battery.capacity_ah"].kind == "published"
    assert found == study_from(compose_tree([])).sources


def test_a_changed_value_does_not_take_the_source_of_the_one_it_replaces(conf: Path) -> None:
    told = r"battery/own\.yaml:6: battery\.capacity_ah = 55, changed from that of .*lead_acid_12v7ah\.yaml"
    with pytest.raises(UserError, match=told):
        sources(conf, capacity_ah=55)


def test_a_changed_value_has_the_source_beside_it_and_nothing_of_the_other(conf: Path) -> None:
    found = sources(conf, acceptance={"resistance_ohm": 0.2}, sources={"acceptance": {"resistance_ohm": ESTIMATE}})
    assert found["battery.acceptance.resistance_ohm"] == Source(**ESTIMATE)  # the range was that of 0.0212 ohm
    assert found["battery.acceptance.time_constant_s"].range == (10.0, 60.0)


def test_a_source_of_several_values_stays_with_those_that_are_not_changed(conf: Path) -> None:
    with pytest.raises(UserError) as refused:
        sources(conf, base="lfp_8ah", thermal={"heat_capacity_j_k": 300})
    assert "battery.thermal.heat_capacity_j_k = 300" in str(refused.value)
    assert "resistance_k_w" not in str(refused.value)


def test_a_source_of_several_values_may_take_the_place_of_single_ones(conf: Path) -> None:
    found = sources(conf, pairs={"fast": {"time_constant_s": 0.01}}, sources={"pairs": ESTIMATE})
    assert {source for path, source in found.items() if path.startswith("battery.pairs")} == {Source(**ESTIMATE)}


def test_a_value_said_again_keeps_its_source(conf: Path) -> None:
    assert sources(conf, capacity_ah=7.0)["battery.capacity_ah"].kind == "published"


def test_a_value_of_the_command_line_is_the_persons_own(conf: Path) -> None:
    found = sources(conf, "battery.capacity_ah=8", capacity_ah=55)
    assert (found["battery.capacity_ah"].kind, found["battery.capacity_ah"].ref) == (
        "override",
        "battery.capacity_ah=8",
    )


def test_a_mistake_names_the_file_that_made_it(conf: Path) -> None:
    with pytest.raises(UserError, match=r"battery/own\.yaml:6: battery\.capacity_ah: value -5; allowed is more than 0"):
        sources(conf, capacity_ah=-5)


def test_a_study_that_changes_a_value_says_where_it_comes_from(conf: Path) -> None:
    study = conf / "study" / "changed.yaml"
    study.write_text((conf / "study" / "solar_reflex.yaml").read_text() + "\nbattery: {capacity_ah: 9.0}\n")
    with pytest.raises(UserError, match=r"study/changed\.yaml:\d+: battery\.capacity_ah = 9"):
        study_from(compose_tree(["study=changed"], conf))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name: [own\n", r"battery/broken\.yaml:\d: not readable YAML"),
        ("name: own\nname: own\n", r"battery/broken\.yaml:2: not readable YAML: found duplicate key name"),
        ("- own\n", r"battery/broken\.yaml: a file of conf/ is a mapping of names to values, not a list"),
        ("name: own\nsources: data sheet\n", r"battery/broken\.yaml:2: battery\.sources: value 'data sheet'; allowed"),
    ],
)
def test_a_file_that_cannot_be_read_is_named(conf: Path, text: str, told: str) -> None:
    (conf / "battery" / "broken.yaml").write_text(text)
    with pytest.raises(UserError, match=told):
        compose_tree(["battery=broken"], conf)
