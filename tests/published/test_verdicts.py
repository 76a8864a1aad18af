"""The verdict, word by word, and the share of the estimated parameters' range over which a claim holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from scipy.stats import binom

from pipeline.kernel import tables
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import VERDICTS, evaluate
from pipeline.published.records import Statement
from pipeline.published.words import RESAMPLED, SEEDS, Robust, counted, word
from tests.published.conftest import FALSE

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


@pytest.mark.parametrize("basis", FALSE)
@pytest.mark.parametrize(
    ("reflex_k", "calibrated_to", "verdict", "margin"),
    [
        (4.0, (), "holds", 1.0),
        (6.0, (), None, -1.0),
        (4.0, ("cooler",), "calibrated", 1.0),
        (6.0, ("cooler",), None, -1.0),
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
    verdict: str | None,
    margin: Any,
) -> None:
    """A model that says otherwise refutes nothing; the paper's own numbers and mathematics do."""
    found = row(statement(basis=basis), lookup(summaries(reflex_k)), calibrated_to)
    assert (found["verdict"], found["margin"]) == (verdict or FALSE[basis], margin)
    assert found["met"] == {1.0: "yes", -1.0: "no", None: ""}[margin]


@pytest.mark.parametrize("basis", ["model", "search"])
@pytest.mark.parametrize(
    ("held", "counted", "expected"),
    [
        (4, 5, "holds"),
        (79, 100, "undecided"),
        (80, 100, "holds"),
        (21, 100, "undecided"),
        (20, 100, "not reproduced"),
        (1, 5, "not reproduced"),
        (64, 128, "undecided"),
        (103, 128, "holds"),
        (102, 128, "undecided"),
        (26, 128, "undecided"),
        (25, 128, "not reproduced"),
    ],
)
@pytest.mark.parametrize("holds", [True, False])
def test_the_word_of_a_model_follows_the_share_and_not_the_own_values(
    basis: Any, held: int, counted: int, expected: str, holds: bool
) -> None:
    assert word(basis, holds, Robust(held, counted)) == expected
    assert word(basis, True, Robust(held, counted), calibrated=True) == "calibrated"
    assert word(basis, False, Robust(held, counted), calibrated=True) == expected


@pytest.mark.parametrize("basis", ["paper_data", "mathematics"])
def test_no_share_softens_the_papers_own_numbers(basis: Any) -> None:
    assert word(basis, False, Robust(100, 100)) == "contradicted"
    assert word(basis, True, Robust(0, 100)) == "holds"


@pytest.mark.parametrize(("held", "counted"), [(0, 24), (11, 24), (13, 24), (24, 24), (103, 128)])
def test_the_interval_is_that_of_the_binomial_distribution(held: int, counted: int) -> None:
    """At either end of Clopper and Pearson's interval what was found, or more extreme, has a chance of 2.5 %."""
    low, high = Robust(held, counted).interval()
    assert 0.0 <= low <= held / counted <= high <= 1.0
    if held:
        assert 1.0 - binom.cdf(held - 1, counted, low) == pytest.approx(0.025, abs=1e-9)
    if held < counted:
        assert binom.cdf(held, counted, high) == pytest.approx(0.025, abs=1e-9)


def test_arithmetic_of_the_paper_is_counted_apart() -> None:
    columns = {"basis": ["paper_data", "model", "none", "paper_data"],
               "verdict": ["contradicted", "undecided", "not checkable", "holds"]}  # fmt: skip
    assert counted(columns) == {
        "statements": [("undecided", 1), ("not checkable", 1)],
        "arithmetic": [("holds", 1), ("contradicted", 1)],
    }


def test_a_mode_left_out_makes_a_statement_not_checkable(lookup: Callable[..., Lookup]) -> None:
    found = row(statement(), lookup({CC: {"rise_k": 5.0}}))
    assert found["verdict"] == "not checkable"
    assert found["explanation"] == f"Missing: {REFLEX} is not part of this run."


def test_basis_none_says_what_is_missing(lookup: Callable[..., Lookup]) -> None:
    found = row(statement(basis="none", check=None, missing="an ageing model."), lookup({}), ("cooler",))
    assert found["verdict"] == "not checkable"
    assert "an ageing model" in found["explanation"]


def test_what_is_ours_stands_beside_what_is_missing_and_answers_nothing(lookup: Callable[..., Lookup]) -> None:
    fields = {"basis": "none", "check": None, "missing": "its data.", "unit": "K", "ours": [f"rise_k of {REFLEX}"]}
    found = row(statement(**fields), lookup(summaries(4.0)))
    assert (found["verdict"], found["met"], found["computed_value"]) == ("not checkable", "", 4.0)
    assert found["explanation"] == "Missing: its data. Ours: rise of cv_reflex (p): 4 K."
    absent = row(statement(**fields), lookup({}))
    assert "Ours is missing too: charge/p/cv_reflex is not part of this run" in absent["explanation"]


def test_a_claim_of_cycle_life_is_not_assessed_and_says_what_would(lookup: Callable[..., Lookup]) -> None:
    fields = {"basis": "none", "check": None, "missing": "no battery is followed", "assessed_by": "cycled batteries"}
    found = row(statement(**fields), lookup({}))
    assert found["verdict"] == "not checkable"
    assert found["explanation"] == "Not assessed: no battery is followed. It would take cycled batteries."


def test_conditions_that_were_not_kept_stand_in_the_table(lookup: Callable[..., Lookup]) -> None:
    assert row(statement(conditions="another cell"), lookup(summaries(4.0)))["conditions"] == "another cell"


@pytest.mark.parametrize(
    "fields",
    [
        {"basis": "none"},
        {"ours": [1.0]},
        {"assessed_by": "cycling"},
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
    assert (found["verdict"], found["computed_value"], found["margin"]) == ("not reproduced", None, None)
    assert "never" in found["explanation"]


RISES = (f"rise_k of {CC}.summary", f"rise_k of {REFLEX}.summary")


def sample(reflex_k: float | None, cc_k: float = 5.0) -> dict[str, float | None]:
    return dict(zip(RISES, (cc_k, reflex_k), strict=True))


Maker = Callable[..., list[Any]]


def test_robust_share_counts_the_points_in_which_the_claim_holds(
    lookup: Callable[..., Lookup], ensemble: Maker
) -> None:
    nominal = lookup(summaries(6.0))
    points = ensemble(nominal, [sample(4.0), sample(6.0), sample(4.9), sample(3.0, 2.0), sample(math.nan)])
    found = row(statement(), nominal, samples=points)
    assert (found["verdict"], found["robust_share"], found["robust_points"]) == ("undecided", 0.4, 5)
    assert found["robust_low"] < 0.4 < found["robust_high"]
    assert "2 of 5 points of the estimated parameters" in found["explanation"]
    assert "1 of the others without an answer" in found["explanation"]


def test_impossible_points_are_left_out_and_counted(lookup: Callable[..., Lookup], ensemble: Maker) -> None:
    nominal = lookup(summaries(6.0))
    points = ensemble(nominal, [sample(4.0), sample(None), sample(4.9), sample(None), sample(6.0)])
    found = row(statement(), nominal, samples=points)
    assert (found["robust_share"], found["robust_points"], found["robust_left_out"]) == (2 / 3, 3, 2)
    assert "2 left out as impossible" in found["explanation"]
    nowhere = row(statement(), nominal, samples=ensemble(nominal, [sample(None)]))
    assert (nowhere["robust_share"], nowhere["verdict"]) == (None, "not reproduced")


@pytest.mark.parametrize(
    "fields",
    [
        {"basis": "paper_data"},
        {"basis": "mathematics"},
        {"basis": "search"},
        {"check": {"less": {"value": "max_power_w of panel where irradiance_w_m2=200", "than": 40}}},
        {"check": {"less": {"value": f"other_k of {REFLEX}", "than": 40}}},
    ],
    ids=["paper data", "mathematics", "a search, which no parameter answers", "no charge", "a number it lacks"],
)
def test_no_robust_share_where_the_ensemble_does_not_answer(
    lookup: Callable[..., Lookup], ensemble: Maker, fields: dict[str, Any]
) -> None:
    nominal = lookup({CC: {"rise_k": 5.0}, REFLEX: {"rise_k": 4.0, "other_k": 1.0}})
    found = row(statement(**fields), nominal, samples=ensemble(nominal, [sample(4.0)]))
    assert found["robust_share"] is None


@pytest.mark.parametrize("of", [SEEDS, RESAMPLED])
def test_a_claim_on_a_search_is_asked_of_other_seeds(lookup: Callable[..., Lookup], ensemble: Maker, of: str) -> None:
    nominal = lookup(summaries(4.0))
    points = ensemble(nominal, [sample(6.0), sample(4.0), sample(6.0)], of=of)
    found = row(statement(basis="search"), nominal, samples=points)
    assert (found["verdict"], found["robust_share"]) == ("undecided", 1 / 3)
    assert f"1 of 3 {of}" in found["explanation"]
    assert row(statement(), nominal, samples=points)["robust_share"] is None


def test_what_does_not_vary_keeps_its_value_in_every_point(lookup: Callable[..., Lookup], ensemble: Maker) -> None:
    value = {"product": [f"rise_k of {REFLEX}", "max_power_w of panel where irradiance_w_m2=200"]}
    nominal = lookup(summaries(1.0))
    points = ensemble(nominal, [sample(1.0), sample(2.0), sample(3.0), sample(4.0)])
    stated = statement(check={"less": {"value": value, "than": 30}})
    assert row(stated, nominal, samples=points)["robust_share"] == 0.5


def test_points_of_two_ensembles_are_the_same_points(lookup: Callable[..., Lookup], ensemble: Maker) -> None:
    """What two ensembles answer together counts in the points that both have; one of them has fewer."""
    nominal = lookup(summaries(6.0))
    cc = [{RISES[0]: 5.0}, {RISES[0]: 5.0}, {RISES[0]: 1.0}, {RISES[0]: 9.0}]
    reflex = [{RISES[1]: 4.0}, {RISES[1]: 6.0}, {RISES[1]: 2.0}]
    found = row(statement(), nominal, samples=ensemble(nominal, cc, reflex))
    assert (found["robust_share"], found["robust_points"]) == (1 / 3, 3)


def test_a_time_without_an_end_is_longer_than_any(lookup: Callable[..., Lookup], ensemble: Maker) -> None:
    quantity = "time_to_soc_0.95_s"
    check = {"less": {"value": f"{quantity} of {CC}", "than": f"{quantity} of {REFLEX}"}}
    nominal = lookup({CC: {quantity: 5000.0}, REFLEX: {quantity: 6000.0}})
    names = [f"{quantity} of {name}.summary" for name in (CC, REFLEX)]
    points = [{names[0]: 5000.0, names[1]: math.nan}, {names[0]: math.nan, names[1]: 5000.0}]
    found = row(statement(check=check, unit="s"), nominal, samples=ensemble(nominal, points))
    assert found["robust_share"] == 0.5


def test_a_value_at_a_time_is_one_number_of_a_point(lookup: Callable[..., Lookup], ensemble: Maker) -> None:
    moment = {"value": f"soc of {REFLEX}.trace", "time": f"time_s of {CC}"}
    nominal = lookup({CC: {"time_s": 5000.0}, REFLEX: {"rise_k": 1.0}})
    name = f"soc of {REFLEX}.trace at time_s of {CC}.summary"
    found = row(
        statement(check={"less": {"value": {"at_time": moment}, "than": 0.6}}),
        nominal,
        samples=ensemble(nominal, [{name: 0.5}, {name: 0.7}]),
    )
    assert (found["met"], found["robust_share"]) == ("yes", 0.5)
