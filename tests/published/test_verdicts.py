"""The verdict, word by word, and the share of the estimated parameters' range over which a claim holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from pipeline.kernel import tables
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import VERDICTS, evaluate
from pipeline.published.records import Statement

CC, REFLEX = "charge/p/cc_cv", "charge/p/cv_reflex"
COOLER = {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {CC}"}}


def statement(**fields: Any) -> Statement:
    return Statement.model_validate({"where": "page 1", "says": "cooler", "basis": "model", "check": COOLER} | fields)


def row(stated: Statement, artefacts: Lookup, calibrated_to: tuple[str, ...] = (), samples: Any = ()) -> dict[str, Any]:
    columns = evaluate({"cooler": stated}, artefacts, calibrated_to, samples)
    tables.to_arrow(VERDICTS, columns)
    return {name: cells[0] for name, cells in columns.items()}


def summaries(reflex_k: float, cc_k: float = 5.0) -> dict[str, dict[str, float]]:
    return {CC: {"rise_k": cc_k}, REFLEX: {"rise_k": reflex_k}}


@pytest.mark.parametrize("basis", ["model", "paper_data"])
@pytest.mark.parametrize(
    ("reflex_k", "calibrated_to", "verdict", "margin"),
    [
        (4.0, (), "holds", 1.0),
        (6.0, (), "contradicted", -1.0),
        (4.0, ("cooler",), "calibrated", 1.0),
        (6.0, ("cooler",), "fails", -1.0),
        (4.0, ("another",), "holds", 1.0),
        (math.nan, (), "not checkable", None),
        (math.nan, ("cooler",), "not checkable", None),
    ],
)
def test_verdict(
    lookup: Callable[..., Lookup],
    basis: str,
    reflex_k: float,
    calibrated_to: tuple[str, ...],
    verdict: str,
    margin: Any,
) -> None:
    found = row(statement(basis=basis), lookup(summaries(reflex_k)), calibrated_to)
    assert (found["verdict"], found["margin"]) == (verdict, margin)


def test_a_mode_left_out_makes_a_statement_not_checkable(lookup: Callable[..., Lookup]) -> None:
    found = row(statement(), lookup({CC: {"rise_k": 5.0}}))
    assert found["verdict"] == "not checkable"
    assert found["explanation"] == f"Missing: {REFLEX} is not part of this run."


def test_basis_none_says_what_is_missing(lookup: Callable[..., Lookup]) -> None:
    found = row(statement(basis="none", check=None, missing="an ageing model."), lookup({}), ("cooler",))
    assert found["verdict"] == "not checkable"
    assert "an ageing model" in found["explanation"]


@pytest.mark.parametrize(
    "fields",
    [
        {"basis": "none"},
        {"basis": "none", "check": None},
        {"check": None},
        {"missing": "something"},
        {"verdict": "holds"},
    ],
)
def test_no_statement_goes_without_a_check_or_with_a_verdict(fields: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"basis|Extra inputs"):
        statement(**fields)


@pytest.mark.parametrize(("form", "published"), [("number", 4.5), ("claim", None)])
def test_only_a_printed_number_is_shown_as_published(lookup: Callable[..., Lookup], form: str, published: Any) -> None:
    check = {"close": {"value": f"rise_k of {REFLEX}", "to": 4.5, "tolerance": 1}}
    found = row(statement(check=check, form=form), lookup(summaries(4.0)))
    assert (found["published_value"], found["computed_value"], found["tolerance"]) == (published, 4.0, 1.0)


def test_an_endless_time_leaves_no_infinity_in_the_table(lookup: Callable[..., Lookup]) -> None:
    quantity = "time_to_soc_0.95_s"
    check = {"less": {"value": f"{quantity} of {REFLEX}", "than": f"{quantity} of {CC}"}}
    found = row(statement(check=check, unit="s"), lookup({CC: {quantity: 5000.0}, REFLEX: {quantity: math.nan}}))
    assert (found["verdict"], found["computed_value"], found["margin"]) == ("contradicted", None, None)
    assert "never" in found["explanation"]


def sample(reflex_k: float, cc_k: float = 5.0) -> dict[tuple[str, str, str], float]:
    return {("p", "cc_cv", "rise_k"): cc_k, ("p", "cv_reflex", "rise_k"): reflex_k}


def test_robust_share_counts_the_samples_in_which_the_claim_holds(
    lookup: Callable[..., Lookup], ensemble: Callable[..., list[Any]]
) -> None:
    samples = [sample(4.0), sample(6.0), sample(4.9), sample(3.0, 2.0), sample(math.nan)]
    found = row(statement(), lookup(summaries(6.0)), samples=ensemble(samples))
    assert (found["verdict"], found["robust_share"]) == ("contradicted", 0.4)
    assert "2 of 5 samples" in found["explanation"]
    assert "1 without an answer" in found["explanation"]


@pytest.mark.parametrize(
    "fields",
    [
        {"basis": "paper_data"},
        {"check": {"less": {"value": "max_power_w of panel where irradiance_w_m2=200", "than": 40}}},
        {"check": {"less": {"value": f"end_s of {CC}.phases where phase=bulk", "than": f"rise_k of {CC}"}}},
        {"check": {"less": {"value": f"other_k of {REFLEX}", "than": f"rise_k of {CC}"}}},
    ],
    ids=["paper data", "no charge", "another table", "a quantity the ensemble lacks"],
)
def test_no_robust_share_where_the_ensemble_does_not_answer(
    lookup: Callable[..., Lookup], ensemble: Callable[..., list[Any]], fields: dict[str, Any]
) -> None:
    charges = {CC: {"rise_k": 5.0}, REFLEX: {"rise_k": 4.0, "other_k": 1.0}}
    found = row(statement(**fields), lookup(charges), samples=ensemble([sample(4.0)]))
    assert found["robust_share"] is None


def test_what_does_not_vary_keeps_its_value_in_every_sample(
    lookup: Callable[..., Lookup], ensemble: Callable[..., list[Any]]
) -> None:
    value = {"product": [f"rise_k of {REFLEX}", "max_power_w of panel where irradiance_w_m2=200"]}
    samples = [sample(1.0), sample(2.0), sample(3.0), sample(4.0)]
    stated = statement(check={"less": {"value": value, "than": 30}})
    assert row(stated, lookup(summaries(1.0)), samples=ensemble(samples))["robust_share"] == 0.5
