"""The answer: who is better, by how much and how surely; no difference is an answer too."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from pipeline.kernel import tables
from pipeline.published.answer import ANSWER, Choice, answered
from pipeline.published.artefacts import Lookup

ONE, OTHER = "charge/p/cc_cv", "charge/p/cv_reflex"
NAMES = {name: f"rise_k of {name}.summary" for name in (ONE, OTHER)}


def choice(**fields: Any) -> Choice:
    among = {"one": f"rise_k of {ONE}", "other": f"rise_k of {OTHER}"}
    given = {"of": "rise", "better": "less", "by": 0.1, "unit": "K", "among": among}
    return Choice.model_validate(given | fields)


def told(choices: dict[str, Choice], nominal: Lookup, samples: Any = ()) -> list[dict[str, Any]]:
    columns = answered(choices, nominal, samples)
    tables.to_arrow(ANSWER, columns)
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def points(*pairs: tuple[float | None, float | None]) -> list[dict[str, float | None]]:
    return [{NAMES[ONE]: one, NAMES[OTHER]: other} for one, other in pairs]


@pytest.fixture
def nominal(lookup: Callable[..., Lookup]) -> Lookup:
    return lookup({ONE: {"rise_k": 5.0}, OTHER: {"rise_k": 4.0}})


def test_the_better_one_is_told_with_its_lead_and_how_sure_it_is(nominal: Lookup, ensemble: Any) -> None:
    samples = ensemble(nominal, points((5.0, 4.0), (5.0, 4.5), (5.0, 4.95), (5.0, 3.0), (6.0, 1.0)))
    total, one = told({"rise": choice()}, nominal, samples)
    assert (one["best"], one["lead"], one["share"]) == ("other", 1.0, 0.8)
    assert one["sentence"] == (
        "Rise: one 5 K, other 4 K. Ahead: other, by 1 K; by 0.1 K or more at 4 of 5 points of the "
        "estimated parameters (28 to 99 %)."
    )
    assert (total["best"], total["sentence"]) == ("other", "Best: other, by 1 K in rise.")


def test_differences_of_temperatures_are_kelvins(nominal: Lookup) -> None:
    assert "Ahead: other, by 1 K." in told({"rise": choice(unit="degC")}, nominal)[1]["sentence"]


@pytest.mark.parametrize(
    ("other", "by", "told"),
    [
        (4.99128, 0.1, "one 5 K, other 4.99 K. Ahead: other, by less than 0.01 K, so no clear difference."),
        (4.9128, 0.1, "one 5 K, other 4.91 K. Ahead: other, by 0.09 K, so no clear difference."),
        (4.0, 40.0, "one 5 K, other 4 K. Ahead: other, by less than 4 K, so no clear difference."),
        (-444.83427, 60.0, "one 5 K, other −445 K. Ahead: other, by 450 K."),
        (-83.97, 15.0, "one 5 K, other −84.0 K. Ahead: other, by 89 K."),
    ],
)
def test_a_lead_is_told_no_finer_than_a_tenth_of_what_matters(lookup: Any, other: float, by: float, told: str) -> None:
    nominal = lookup({ONE: {"rise_k": 5.0}, OTHER: {"rise_k": other}})
    found = answered({"rise": choice(by=by)}, nominal, [])["sentence"][1]
    assert found == f"Rise: {told}"


def test_what_is_larger_may_be_the_better_one(nominal: Lookup) -> None:
    total, one = told({"rise": choice(better="greater")}, nominal)
    assert (total["best"], one["best"], one["lead"], one["share"]) == ("one", "one", 1.0, None)


@pytest.mark.parametrize(
    "pairs",
    [
        [(5.0, 4.0), (5.0, 4.0), (4.0, 5.0), (4.0, 5.0)],
        [(5.0, 4.95), (5.0, 4.96), (5.0, 4.97)],
        [(5.0, 4.0), (5.0, math.nan), (math.nan, 4.0)],
    ],
    ids=["another is better as often", "less than what matters", "no answer"],
)
def test_no_difference_that_is_sure_is_an_answer(nominal: Lookup, ensemble: Any, pairs: Any) -> None:
    total, one = told({"rise": choice()}, nominal, ensemble(nominal, points(*pairs)))
    assert one["best"] == total["best"] == ""
    assert "Ahead: other, by 1 K; by 0.1 K or more at" in one["sentence"]
    assert one["sentence"].endswith("%), so no clear difference.")
    assert total["sentence"] == "No alternative is clearly better. No clear difference in rise."


def test_a_lead_below_what_matters_is_none(nominal: Lookup) -> None:
    assert [row["best"] for row in told({"rise": choice(by=1.5)}, nominal)] == ["", ""]


def test_impossible_points_do_not_count(nominal: Lookup, ensemble: Any) -> None:
    samples = ensemble(nominal, points((5.0, 4.0), (None, 4.0), (5.0, None)))
    assert told({"rise": choice()}, nominal, samples)[1]["share"] == 1.0


def test_where_different_ones_are_better_it_depends(nominal: Lookup) -> None:
    choices = {"cool": choice(), "warm": choice(of="warmth", better="greater"), "same": choice(of="sameness", by=9.0)}
    total = told(choices, nominal)[0]
    assert total["best"] == ""
    assert total["sentence"] == (
        "It depends on what counts: other for rise; one for warmth. No clear difference in sameness."
    )


def test_what_a_run_does_not_hold_is_not_answered(lookup: Callable[..., Lookup]) -> None:
    (only,) = told({"rise": choice()}, lookup({ONE: {"rise_k": 5.0}}))
    assert only["best"] == ""
    assert "no answer, since charge/p/cv_reflex is not part of this run" in only["sentence"]
