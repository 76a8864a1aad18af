"""The study of the engine: made when it is asked for, with a node for each check and nothing charged."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from pipeline.commands.workflow import wanted
from pipeline.config.compose import cards, compose_tree, options
from pipeline.config.study import study_from
from pipeline.experiments.validation import registry
from pipeline.kernel.draft import drafts

CARDS = {"one": {}, "two": {"on_request": {"two_large": ["size=large"]}}, "apart": {"apart": True}}


@pytest.mark.parametrize(
    ("asked", "studies"),
    [
        ([], ["one", "two"]),
        (["--cores", "2", "all"], ["one", "two"]),
        (["--cores", "2", "apart"], ["apart"]),
        (["-n", "one"], ["one"]),
        (["one", "apart"], ["one", "apart"]),
        (["all", "apart"], ["one", "two", "apart"]),
        (["figures", "one"], ["one", "two"]),
        (["two_large"], ["one", "two"]),
        (["two_large", "one"], ["one", "two"]),
        (["results/store/x", "one"], ["one", "two"]),
    ],
)
def test_only_what_is_asked_for_is_composed(asked: list[str], studies: list[str]) -> None:
    assert wanted(CARDS, asked) == studies


def test_the_study_of_the_engine_and_that_of_a_file_stand_apart() -> None:
    assert sorted(name for name, card in cards().items() if card.get("apart")) == ["own_battery", "validation"]
    assert set(cards()) == set(options("study"))


@cache
def study() -> Any:
    return study_from(compose_tree(["study=validation"]))


def test_every_check_has_a_node_and_nothing_is_charged(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = drafts(study())
    assert {node.step for node in nodes} == {"validation", "figures", "page"}
    checks = [node for node in nodes if node.step == "validation"]
    assert [node.label for node in checks] == list(registry.CHECKS)
    assert all(node.modules == (registry.module_name(node.label),) for node in checks)
    page = next(node for node in nodes if node.step == "page")
    assert set(page.inputs) == {node.name for node in nodes} - {"page"}


def test_an_installed_code_is_part_of_its_own_check_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for version in (None, "1.0"):
        monkeypatch.setattr(
            "pipeline.experiments.validation.declaration.installed", lambda peer, version=version: version
        )
        found.append({node.name: node.settings for node in drafts(study()) if node.step == "validation"})
    differing = {name for name in found[0] if found[0][name] != found[1][name]}
    assert differing == {"validation/against_pybamm", "validation/against_ngspice"}


def test_every_chemistry_and_every_waveform_is_tried() -> None:
    validation = study().validation
    assert validation is not None
    law = validation.first_law
    kinds = {type(phase.waveform).__name__ for mode in law.modes.values() for phase in mode.phases.values()}
    assert {"ConstantCurrent", "ConstantVoltage", "Pulse", "Reflex", "Staged", "RateSwitch"} == kinds
    # Those left out are calibrations of one that is there.
    assert {name for name in options("battery") if not name.startswith("lfp_8ah_")} == set(law.batteries)
