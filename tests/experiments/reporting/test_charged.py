"""Which statements charges alone answer, and their verdicts on another battery's charges."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pipeline.experiments.reporting.verdicts import answered_by_charges, in_place_of_the_first, of_second, samples
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import evaluate
from pipeline.published.records import Statement, needs
from pipeline.published.words import PARAMETERS, SEEDS
from tests import making
from tests.published.conftest import lookup, shipped, write_ensemble

__all__ = ["lookup", "shipped"]

COOLER = {"less": {"value": "rise_k of charge/p/cv_reflex", "than": "rise_k of charge/p/cc_cv"}}


def test_they_are_those_on_speed_temperature_efficiency_and_operation(shipped: dict[str, Statement]) -> None:
    asked = answered_by_charges(shipped)
    assert len(asked) == 18
    assert {name.split("/")[0] for stated in asked.values() for name in needs(stated)} == {"charge"}
    assert {"table_1", "mode_switched_after_an_hour", "table_3", "chaos_speeds_up", "cycle_life"}.isdisjoint(asked)


def test_a_statement_that_reads_a_charge_and_something_else_is_not_among_them() -> None:
    operands = {"value": "rise_k of charge/p/cv_reflex", "than": "max_power_w of panel"}
    stated = {"where": "x", "says": "y", "basis": "model"}
    both = Statement.model_validate(stated | {"check": {"less": operands}})
    alone = Statement.model_validate(stated | {"check": COOLER})
    assert list(answered_by_charges({"both": both, "alone": alone})) == ["alone"]


def test_the_same_predicate_on_the_other_charges(lookup: Callable[..., Lookup], tmp_path: Any) -> None:
    rises = {
        "charge/p/cc_cv": 5.0,
        "charge/p/cv_reflex": 4.0,
        "second_charge/p/cc_cv": 5.0,
        "second_charge/p/cv_reflex": 6.0,
    }
    first = lookup({name: {"rise_k": rise} for name, rise in rises.items()})
    inputs = making.inputs({name: tmp_path / name for name in [*rises, "panel"]})
    stated = Statement.model_validate({"where": "x", "says": "y", "basis": "model", "check": COOLER})
    assert {of_second(name) for name in needs(stated)} == {name for name in rises if name.startswith("second")}
    second = Lookup(inputs.renamed(in_place_of_the_first(inputs)))
    assert evaluate({"cooler": stated}, first)["verdict"] == ["holds"]
    found = evaluate({"cooler": stated}, second, ["another"])
    assert (found["verdict"], found["margin"]) == (["not reproduced"], [-1.0])
    assert set(in_place_of_the_first(inputs)) == {"charge/p/cc_cv", "charge/p/cv_reflex"}


def test_points_of_several_ensembles_are_joined_and_impossible_ones_are_none(tmp_path: Any) -> None:
    write_ensemble(tmp_path / "a", [{"x of a.t": 5.0}, {"x of a.t": None}])
    write_ensemble(tmp_path / "b", [{"y of b.t": 1.0}])
    write_ensemble(tmp_path / "c", [{"x of a.t": 7.0}], SEEDS)
    inputs = making.inputs({f"ensemble/{name}": tmp_path / name for name in "abc"})
    found = samples(inputs, Lookup(inputs))
    assert [(one.of, dict(one.numbers)) for one in found] == [
        (SEEDS, {"x of a.t": 7.0}),
        (PARAMETERS, {"x of a.t": 5.0, "y of b.t": 1.0}),
        (PARAMETERS, {"x of a.t": None}),
    ]
    assert samples(making.inputs({}), Lookup(inputs)) == []
