"""Points over the ranges of estimated parameters: even, repeatable, the same for all ensembles of a study."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.stats import qmc

from pipeline.config.sources import Source
from pipeline.published import ensemble
from pipeline.published.artefacts import Unanswerable
from pipeline.published.operands import AtTime, Value, text
from pipeline.published.records import Statement
from pipeline.published.words import PARAMETERS


def source(low: float | None = None, high: float | None = None, same_as: str | None = None) -> Source:
    limits = None if low is None or high is None else (low, high)
    return Source(kind="estimate", range=limits, same_as=same_as)


SOURCES = {
    "battery.thermal.heat_capacity_j_k": source(10.0, 20.0),
    "battery.capacity_ah": source(),
    "modes.a.current_a": source(1.0, 2.0),
    "modes.b.current_a": source(1.0, 2.0),
    "modes.b.charge_a": source(same_as="current_a"),
    "modes.c.current_a": source(1.0, 3.0),
    "objective.soc": source(0.0, 1.0),
    "tracker.duty": source(0.0, 1.0),
}


def test_points_are_scrambled_sobols_and_lie_evenly() -> None:
    """Every parameter has one point in each of 128 strips of its range, as a Sobol sequence has."""
    estimated = ensemble.estimates(SOURCES, ["battery", "modes.a", "modes.c", "objective"])
    points = ensemble.draw(estimated, 128, 7)
    assert len(points) == 128
    for path, (low, high) in estimated["ranges"].items():
        unit = (np.array([point[path] for point in points]) - low) / (high - low)
        assert sorted(np.floor(128 * unit).astype(int)) == list(range(128)), path
    expected = qmc.Sobol(d=ensemble.DIMENSIONS, scramble=True, rng=np.random.default_rng(7)).random(128)[:, :4]
    names = ["battery.thermal.heat_capacity_j_k", "modes.a.current_a", "modes.c.current_a", "objective.soc"]
    low, high = np.array([estimated["ranges"][name] for name in names]).T
    np.testing.assert_allclose([[point[name] for name in names] for point in points], low + (high - low) * expected)
    assert ensemble.draw(estimated, 128, 7) == points
    assert ensemble.draw(estimated, 64, 7) == points[:64]
    assert ensemble.draw(estimated, 128, 8) != points


def test_knobs_of_one_name_and_range_are_one_and_followers_follow() -> None:
    estimated = ensemble.estimates(SOURCES, ["modes.a", "modes.b", "modes.c"])
    for point in ensemble.draw(estimated, 16, 1):
        assert point["modes.a.current_a"] == point["modes.b.current_a"] == point["modes.b.charge_a"]
        assert point["modes.c.current_a"] != point["modes.a.current_a"]


def test_ensembles_of_a_study_share_their_points() -> None:
    """A parameter has the same value in a point of every ensemble that varies it; what none varies moves nothing."""
    one = ensemble.draw(ensemble.estimates(SOURCES, ["battery", "modes.a"]), 32, 3)
    other = ensemble.draw(ensemble.estimates(SOURCES, ["battery", "objective"]), 16, 3)
    for first, second in zip(one, other, strict=False):
        assert first["battery.thermal.heat_capacity_j_k"] == second["battery.thermal.heat_capacity_j_k"]
    without = {path: found for path, found in SOURCES.items() if path != "tracker.duty"}
    assert ensemble.estimates(without, ["battery"]) == ensemble.estimates(SOURCES, ["battery"])
    later = SOURCES | {"converter.switched.buck.inductance_h": source(1.0, 2.0), "objective.a": source(1.0, 2.0)}
    assert ensemble.estimates(later, ["battery", "modes.c"]) == ensemble.estimates(SOURCES, ["battery", "modes.c"])


def test_without_ranges_every_point_is_the_studys_own() -> None:
    assert ensemble.draw(ensemble.estimates({"battery.capacity_ah": source()}, ["battery"]), 4, 1) == [{}] * 4


def test_values_are_put_where_they_belong_and_the_tree_stays_as_it_was() -> None:
    tree = {"battery": {"thermal": {"heat_capacity_j_k": 15.0}, "cells": 2}}
    found = ensemble.with_values(tree, {"battery.thermal.heat_capacity_j_k": 11.0, "modes.a.current_a": 1.0})
    assert found == {"battery": {"thermal": {"heat_capacity_j_k": 11.0}, "cells": 2}}
    assert tree["battery"]["thermal"] == {"heat_capacity_j_k": 15.0}
    with pytest.raises(KeyError):
        ensemble.with_values(tree, {"battery.mass_kg": 1.0})


@pytest.mark.parametrize("points", [3, 24, 100])
def test_sobols_points_are_a_power_of_two(points: int) -> None:
    with pytest.raises(ValidationError, match="power of two"):
        ensemble.EnsembleSettings(points=points)


def statement(basis: str, value: Any) -> Statement:
    check = {"less": {"value": value, "than": "x of panel.points"}}
    return Statement.model_validate({"where": "p", "says": "s", "basis": basis, "check": check})


def test_what_is_asked_is_read_by_statements_of_the_basis_and_answers_in_the_same_words() -> None:
    moment = {"at_time": {"value": "soc of charge/p/a.trace", "time": "t_s of charge/p/a.summary"}}
    published = {
        "one": statement("model", "t_s of charge/p/a.summary"),
        "two": statement("model", {"product": [2.0, moment]}),
        "three": statement("search", "t_s of charge/p/b.summary"),
        "four": statement("paper_data", "t_s of charge/p/c.summary"),
    }
    config = SimpleNamespace(published=published, answer={})
    found = ensemble.asked(config, ["charge"])
    assert len(found) == 2
    assert ensemble.asked(config, ["panel"]) == [Value(quantity="x", artefact="panel", table="points").model_dump()]
    held = {
        "charge/p/a": {
            "summary": {"quantity": ["t_s"], "value": [5.0], "unit": ["s"], "text": [None]},
            "trace": {"time": [0.0, 10.0], "soc": [0.0, 1.0]},
        }
    }
    from pipeline.experiments.charges.tables import CHARGE  # only its declared tables are wanted here

    held["charge/p/a"]["trace"] = {"Test Time / s": [0.0, 10.0], "soc": [0.0, 1.0]}
    rows = list(ensemble.answers(3, found, ensemble.reader(held, {"charge": CHARGE})))
    moment_text = text(AtTime.model_validate(moment))
    assert set(rows) == {
        (3, "t_s of charge/p/a.summary", 5.0, 1, PARAMETERS),
        (3, moment_text, 0.5, 1, PARAMETERS),
    }
    assert {row[2:4] for row in ensemble.answers(4, found, None)} == {(None, 0)}
    assert {row[2:4] for row in ensemble.answers(5, found, ensemble.reader({}))} == {(None, 1)}


def test_what_is_kept_reads_as_what_is_written() -> None:
    kept = ensemble.Kept()
    kept.write("ensemble", {"point": [0], "value": [1.0]})
    kept.found({"anything": object()})
    reader = ensemble.reader({"a": kept.tables})
    assert reader.column(Value(quantity="value", artefact="a", table="ensemble")).tolist() == [1.0]
    with pytest.raises(Unanswerable):
        reader.column(Value(quantity="value", artefact="b", table="ensemble"))


def test_other_seeds_are_none_of_the_studys_own_and_all_different() -> None:
    found = ensemble.seeds(20150401, 64)
    assert len({*found, 20150401}) == 65
    assert ensemble.seeds(20150401, 8) == found[:8]
