"""Claims: readings of one sentence stand together; close calls are said; places of a paper are read."""

from __future__ import annotations

import pytest

from pipeline.report.claims import Rests, cited, claims, matrix
from tests.report_pages.conftest import verdict_columns


def of(columns: dict[str, list], **changed: list) -> dict[str, list]:
    return columns | changed


def test_readings_of_one_sentence_are_one_claim() -> None:
    columns = of(
        verdict_columns("holds", "undecided", "holds"),
        statement=["cc_cv_fastest_same_peak", "cc_cv_fastest_same_mean", "table_1"],
        says=["fast", "fast", "65 W"],
    )
    first, second = claims(columns, {}, {}, [], {"cc_cv": "CC-CV"})
    assert (first.name, [one.reading for one in first.verdicts]) == ("CC-CV fastest", ["same peak", "same mean"])
    assert (second.name, [one.reading for one in second.verdicts]) == ("Table 1", ["as stated"])


def test_the_matrix_holds_every_verdict_once() -> None:
    names = ["a_same_peak", "a_same_mean", "b_same_peak", "b_same_mean", "c_by_share", "c_by_count", "d"]
    columns = of(verdict_columns(*["holds"] * 7), statement=names, says=["a", "a", "b", "b", "c", "c", "d"])
    ((basis, heads, rows),) = matrix(claims(columns, {}, {}, []))
    assert (basis, heads) == ("our model", ["as stated", "same peak", "same mean"])
    assert sorted(one.name for _, cells in rows for cell in cells for one in cell) == sorted(names)
    assert [len(cells) for _, cells in rows] == [3] * 5
    assert [claim.name for claim, _ in rows][2:4] == ["C: by share", "C: by count"]


def test_readings_whose_names_share_nothing_are_called_by_their_names() -> None:
    columns = of(verdict_columns("holds", "holds"), statement=["charge_equal", "energy_equal"], says=["a", "a"])
    ((_, _, rows),) = matrix(claims(columns, {}, {}, []))
    assert [claim.name for claim, _ in rows] == ["Charge equal", "Energy equal"]


def test_a_margin_of_less_than_a_hundredth_is_a_close_call() -> None:
    columns = verdict_columns("contradicted", "contradicted", "not checkable")
    found = claims(of(columns, computed_value=[1.0504, 1.2, 1.0504], margin=[-0.0004, -0.15, -0.0004],
                      robust_low=[None] * 3, robust_high=[None] * 3), {}, {}, [])  # fmt: skip
    assert [bool(one.verdicts[0].close) for one in found] == [True, False, False]


def test_where_a_tolerance_is_given_a_close_call_is_a_matter_of_it() -> None:
    """An echo that meets its number exactly is none, however small the tolerance is beside the number."""
    columns = of(verdict_columns("holds", "holds", "contradicted"), robust_low=[None] * 3, robust_high=[None] * 3)
    found = claims(
        of(columns, computed_value=[3600.0, 1.0496, 1534.6], margin=[1.0, 0.0004, -0.1], tolerance=[1.0, 0.05, 0.5]),
        *({}, {}, []),
    )
    told = [one.verdicts[0].close for one in found]
    assert told == ["", "its margin is 0.8 % of the tolerance", ""]


def test_a_statement_with_a_title_is_called_by_it() -> None:
    columns = of(
        verdict_columns("holds", "holds", "holds"),
        statement=["table_2_and_figure_10", "table_2_sums", "eight_c"],
        says=["a", "a", "b"],
    )
    titled = {"table_2_and_figure_10": Rests(title="Table 2 against Figure 10"), "eight_c": Rests(title="8C faster")}
    ((_, _, rows),) = matrix(claims(columns, titled, {}, []))
    assert [claim.name for claim, _ in rows] == ["Table 2 against Figure 10", "Table 2: sums", "8C faster"]
    assert claims(columns, titled, {}, [])[1].verdicts[0].reading == "as stated"


def test_an_interval_that_spans_the_limit_between_words_is_a_close_call() -> None:
    columns = verdict_columns("holds", "holds", "not reproduced", "undecided")
    found = claims(of(columns, robust_low=[0.75, 0.85, 0.1, 0.1], robust_high=[0.9, 0.99, 0.3, 0.3]), {}, {}, [])
    assert [bool(one.verdicts[0].close) for one in found] == [True, False, True, False]


@pytest.mark.parametrize(
    ("where", "what", "found"),
    [
        ("section 4, Figures 13 and 15", "Figure", {"Figure 13", "Figure 15"}),
        ("Figures 11 to 13", "Figure", {"Figure 11", "Figure 12", "Figure 13"}),
        ("Table II against Figure 2", "Table", {"Table II"}),
        ("Table II against Figure 2", "Figure", {"Figure 2"}),
        ("abstract", "Figure", set()),
    ],
)
def test_figures_and_tables_that_a_place_names(where: str, what: str, found: set[str]) -> None:
    assert cited(where, what) == found
