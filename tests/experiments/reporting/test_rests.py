"""What the page says that an answer rests on: files, keys, places and rules that are there."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest
import yaml

from pipeline.config.planning import run_of
from pipeline.errors import UserError
from pipeline.kernel import registry
from pipeline.kernel.plan import Run

PROJECT = Path(__file__).resolve().parents[3]


@cache
def run(*words: str) -> Run:
    return run_of(words)


def told(found: Run) -> dict:
    (page,) = [node for node in found.nodes if node.step == "page"]
    return page.settings


def test_every_statement_is_written_where_the_page_says() -> None:
    rests = told(run("study=nicd_grnn"))["rests"]
    written = {
        file: yaml.safe_load((PROJECT / file).read_text(encoding="utf-8"))
        for file in {o["file"] for o in rests.values()}
    }
    assert rests
    assert all(one["key"] in written[one["file"]] for one in rests.values())


def test_the_commands_ask_for_files_of_the_run_and_for_rules_that_are_there() -> None:
    found = run("study=nicd_grnn")
    places = {f"results/nicd_grnn/default/{place}" for node in found.nodes for place in node.shown.values()}
    rules = {step.rule for step in registry.steps().values()}
    for one in told(found)["rests"].values():
        words, _, forced = one["command"].partition(" --forcerun ")
        assert set(forced.split()) <= rules
        asked = re.findall(r"results/\S+", words)
        assert set(asked) <= places
        assert asked or set(words.split()[3:-2]) <= set(registry.targets())


def test_an_answer_leads_to_the_parameters_that_were_fitted_to_it() -> None:
    rests = told(run("study=nicd_grnn"))["rests"]
    assert "battery.side_reaction.current_a" in rests["stop_4c"]["fitted"]
    assert rests["charge_by_stop_4c"]["fitted"] == []
    assert rests["stop_4c"]["owners"] == ["charges"]
    assert "battery_temperature" in rests["stop_4c"]["figures"]


def test_the_overrides_of_a_run_are_in_its_commands_and_its_place() -> None:
    settings = told(run("study=nicd_grnn", "seed=7"))
    assert settings["place"] == "nicd_grnn/seed=7"
    assert all("seed=7" in one["command"] for one in settings["rests"].values())


def test_a_picture_of_the_answer_that_is_not_there_is_refused_where_it_was_asked_for() -> None:
    with pytest.raises(UserError, match=r"hero: no figure 'trade_of' in this run; best matches are: trade_off"):
        run("study=nicd_grnn", "hero=trade_of")
    assert told(run("study=nicd_grnn", "~figures.trade_off"))["hero"] == "trade_off"
