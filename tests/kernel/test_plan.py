"""What enters a key, and what does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.planning import run_of
from pipeline.config.study import study_from
from pipeline.kernel import digest, plan
from pipeline.kernel.draft import drafts

DAYS = {f"day/{weather}/cv_reflex_hourly" for weather in ("clear", "half_cloudy", "overcast")}
HOURLY = {
    f"{kind}/{comparison}/cv_reflex_hourly"
    for kind in ("charge", "second_charge")
    for comparison in ("same_peak", "same_mean")
}


def _keys(change: Callable[[dict[str, Any]], None], words: tuple[str, ...] = ()) -> dict[str, str]:
    """Return node -> digest of its settings, after a change to the composed tree."""
    composed = compose_tree(words)
    change(composed.tree)
    return {node.name: digest.of_value(node.settings, ordered=True) for node in drafts(study_from(composed))}


def _same(tree: dict[str, Any]) -> None:
    pass


def _swap_phases(tree: dict[str, Any]) -> None:
    phases = tree["modes"]["cv_reflex_hourly"]["phases"]
    tree["modes"]["cv_reflex_hourly"]["phases"] = dict(reversed(list(phases.items())))


def _retitle(tree: dict[str, Any]) -> None:
    tree["modes"]["cc_cv"]["title"] = "Constant current"


def _resource(tree: dict[str, Any]) -> None:
    tree["battery"]["sources"]["capacity_ah"]["ref"] = "another reference"


def _swap_figures(tree: dict[str, Any]) -> None:
    tree["figures"] = dict(reversed(list(tree["figures"].items())))


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (_same, set()),
        (_swap_phases, {*HOURLY, *DAYS, "page"}),
        (_resource, {"page"}),
        (_swap_figures, {"page"}),
    ],
    ids=["nothing", "the order of phases", "a source", "the order of figures"],
)
def test_what_changes_a_key(change: Callable[[dict[str, Any]], None], expected: set[str]) -> None:
    words = ("modes.run=[cc_cv,cv_reflex_hourly]",)
    before, after = _keys(_same, words), _keys(change, words)
    assert {name for name in before if before[name] != after[name]} == expected


def test_the_version_of_python_is_part_of_every_key(monkeypatch: pytest.MonkeyPatch) -> None:
    before = run_of(["study=nicd_grnn"]).keys
    monkeypatch.setattr(plan, "PYTHON", "3.12")
    after = run_of(["study=nicd_grnn"]).keys
    assert before.keys() == after.keys()
    assert not set(before.values()) & set(after.values())


def test_a_title_charges_nothing_again() -> None:
    """It stands in what is drawn and told: in the figures, on the page, in the sentences of the verdicts."""
    before, after = _keys(_same), _keys(_retitle)
    changed = {name.split("/")[0] for name in before if before[name] != after[name]}
    assert changed == {"figure", "page", "verdicts"}


def test_a_value_calibrated_in_the_reference_mode_reaches_the_modes_compared_with_it() -> None:
    composed = compose_tree([])
    source = {"kind": "calibrated", "ref": "fit", "to": "solar_reflex.pulse_cooler_same_mean"}
    composed.tree["modes"]["cc_cv"]["sources"]["max_current_a"] = source
    nodes = {node.name: node for node in drafts(study_from(composed))}
    assert nodes["verdicts"].settings["calibrated"]["pulse_cooler_same_mean"] == ["modes.cc_cv.max_current_a"]


def test_an_overridden_leader_leaves_its_followers_alone() -> None:
    nodes = {node.name: node for node in drafts(study_from(compose_tree(["modes.cv_reflex.max_current_a=2.5"])))}
    assert "modes.cv_reflex.charge_a" not in nodes["ensemble/charge"].settings["estimated"]["followers"]
    assert "modes.cv_pulse.charge_a" in nodes["ensemble/charge"].settings["estimated"]["followers"]
