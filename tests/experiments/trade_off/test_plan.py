"""The plan of the nickel-cadmium study: what waits for the network, what comparisons change, what enters a key."""

from __future__ import annotations

from typing import Any

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel import digest
from pipeline.kernel.draft import drafts

STUDY = "study=nicd_grnn"


def composed(*words: str) -> Any:
    return study_from(compose_tree([STUDY, *words]))


@pytest.fixture(scope="module")
def study() -> Any:
    return composed()


def keys(study: Any) -> dict[str, str]:
    return {node.name: digest.of_value(node.settings, ordered=True) for node in drafts(study)}


def test_only_the_networks_charges_wait_for_it(study: Any) -> None:
    waiting = {node.name for node in drafts(study) if "network" in node.inputs and not node.name.startswith("figure/")}
    assert waiting == {
        *("charge/stopped/grnn", "charge/unstopped/grnn", "trade_off", "verdicts", "page"),
        *(f"ensemble/{name}" for name in ("charge", "trade_off", "network")),
    }


def test_a_comparison_heeds_the_stops_it_names(study: Any) -> None:
    nodes = {node.name: node for node in drafts(study)}
    stopped, unstopped = (nodes[f"charge/{name}/constant_4c"].settings["mode"]["stop"] for name in study.comparisons)
    assert stopped["voltage_drop_v"] == 0.02
    assert {name: value for name, value in unstopped.items() if value is not None} == {"elapsed_s": 1400.0}
    assert nodes["ensemble/charge"].settings["stops"] == {"unstopped": []}


def test_a_title_computes_nothing(study: Any) -> None:
    tree = compose_tree([STUDY])
    tree.tree["trade_off"]["conditions"]["paper"]["title"] = "the paper's room"
    tree.tree["trade_off"]["sensors"]["steps"]["title"] = "coarse"
    tree.tree["modes"]["grnn"]["title"] = "network"
    before, after = keys(study), keys(study_from(tree))
    changed = {name.split("/")[0] for name in before if before[name] != after[name]}
    assert changed == {"figure", "page"}


def test_another_networks_centres_are_charged_with(study: Any) -> None:
    other = composed("modes.grnn.phases.charge.controller.network.value=greedy")
    before, after = keys(study), keys(other)
    changed = {name for name in before if before[name] != after[name] and not name.startswith("figure/")}
    assert changed >= {"charge/stopped/grnn", "charge/unstopped/grnn", "trade_off"}
    assert not changed & {"network", "surface", "charge/stopped/constant_4c", "charge/stopped/plain_rule"}


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("modes.grnn.phases.charge.controller.network.value=genetics", "network finds no 'genetics'.*genetic"),
        ("modes.grnn.phases.charge.controller.network.from=net", "no step 'net' finds values.*network"),
        ("modes.grnn.sample_interval_s=0", "sample_interval_s.*must be greater than 0"),
        ("modes.grnn.rate_span_s=2.5", "rate_span_s: 2.5 s is no whole number of samples of 1 s"),
        ("modes.constant_4c.stop.voltage_drop_v=-1", "voltage_drop_v: -1; it must be greater than 0"),
        ("+modes.constant_4c.stop.voltage_dropp_v=1", "voltage_dropp_v.*voltage_drop_v"),
        ("trade_off.c_rates=[4,2]", "c_rates are .*must rise"),
        ("+comparisons.unstopped.stops=[voltage_drop]", "comparisons.unstopped.stops"),
    ],
)
def test_a_mistake_is_named_with_its_key(word: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        composed(word)


def test_a_run_without_the_network_asks_for_none_and_says_so_in_its_verdicts() -> None:
    nodes = {node.name: node for node in drafts(composed("modes.run=[constant_4c]"))}
    assert "network" not in nodes["charge/stopped/constant_4c"].inputs
    assert "network" not in nodes["trade_off"].inputs
    assert list(nodes["trade_off"].settings["modes"]) == []


def test_what_is_fitted_to_a_statement_marks_it(study: Any) -> None:
    node = next(node for node in drafts(study) if node.name == "verdicts")
    surface = [f"network.data.surfaces.plateau_ramp.{name}" for name in ("rates_c", "temperatures_c")]
    assert node.settings["calibrated"] == {
        "overcharge_shows_4c": ["battery.side_reaction.current_a"],
        "table_2": surface,
    }
