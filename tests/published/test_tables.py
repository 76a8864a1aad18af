"""Tables compared cell by cell, and claims on rows of printed tables."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import TypeAdapter

from pipeline.errors import UserError
from pipeline.published.artefacts import Lookup, Unanswerable
from pipeline.published.predicates import apply
from pipeline.published.records import Check
from tests import making

CHECK: TypeAdapter[Check] = TypeAdapter(Check)
RUNS = "run,c1,ise\n1,0.5,15.5\n2,1,13.25\n3,0.5,14.0\n4,1,14.5\n"


def compare(tmp_path: Path, printed: str, computed: str, column: str = "c1"):
    for name, text in (("printed", printed), ("computed", computed)):
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    check = {
        "table_equals": {
            "published": "reference/printed.printed",
            "computed": "reference/computed.computed",
            "by": ["level"],
            "columns": {"c1": column},
            "tolerance": 0.25,
        }
    }
    return apply(CHECK.validate_python(check), printed_in(tmp_path), "1")


def printed_in(folder: Path) -> Lookup:
    return Lookup(making.inputs({}), folder)


def test_rows_are_matched_by_key_not_by_place(tmp_path: Path) -> None:
    found = compare(tmp_path, "level,c1\n1,10\n2,20\n", "level,c1\n2,20\n1,10.125\n3,99\n")
    assert (found.holds, found.margin) == (True, 0.125)


def test_one_wrong_cell_fails_the_table(tmp_path: Path) -> None:
    found = compare(tmp_path, "level,c1\n1,10\n2,20\n", "level,c1\n1,10\n2,21\n")
    assert (found.holds, found.margin) == (False, -0.75)
    assert "column c1, row 2" in found.sentence


@pytest.mark.parametrize("computed", ["level,c1\n1,10\n", "level,c1\n1,10\n2,\n"])
def test_a_missing_row_or_cell_concludes_nothing(tmp_path: Path, computed: str) -> None:
    with pytest.raises(Unanswerable):
        compare(tmp_path, "level,c1\n1,10\n2,20\n", computed)


def test_an_unknown_column_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no column 'c9'"):
        compare(tmp_path, "level,c1\n1,10\n", "level,c1\n1,10\n", "c9")


@pytest.mark.parametrize(("target", "holds"), [(29.5, True), (29.6, False)])
def test_a_sum_over_rows_of_a_printed_table(tmp_path: Path, target: float, holds: bool) -> None:
    (tmp_path / "runs.csv").write_text(RUNS, encoding="utf-8")
    check = {"close": {"value": {"total": "ise of reference/runs where c1=0.5"}, "to": target, "tolerance": 0.01}}
    assert apply(CHECK.validate_python(check), printed_in(tmp_path), "1").holds is holds


def test_the_best_row_of_a_printed_table(tmp_path: Path) -> None:
    (tmp_path / "runs.csv").write_text(RUNS, encoding="utf-8")
    rows = [f"ise of reference/runs where run={number}" for number in range(1, 5)]
    reader = printed_in(tmp_path)
    check = {"smallest": {"value": rows[1], "among": [rows[0], rows[2], rows[3]]}}
    found = apply(CHECK.validate_python(check), reader, "1")
    assert (found.holds, found.margin) == (True, 0.75)
