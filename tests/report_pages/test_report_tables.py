"""Tables of the report, from artefacts to CSV."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from pipeline.report import tables
from tests.report_pages.conftest import verdict_columns


def test_csv_reads_back() -> None:
    table = tables.ReportTable("t", "", "", ("a", "b"), (('x, "y"', 1 / 3), (None, 2.0)))
    assert list(csv.reader(io.StringIO(tables.to_csv(table)))) == [["a", "b"], ['x, "y"', "0.3333333333"], ["", "2"]]


def test_verdicts_keep_every_column() -> None:
    columns = verdict_columns("holds", "not reproduced")
    columns["margin"] = np.array([0.25, np.nan])
    table = tables.verdicts(columns)
    assert table.header == tuple(columns)
    assert [row[table.header.index("margin")] for row in table.rows] == [0.25, None]


def test_parameters_carry_source_and_range() -> None:
    found = tables.Parameter("cell.pairs", (1.0, 2.0), "ohm", "estimate", "a guess", 0.5, 4.0)
    assert tables.parameters([found]).rows == (("cell.pairs", "1.0, 2.0", "ohm", "estimate", "a guess", 0.5, 4.0, ""),)


@pytest.mark.parametrize(
    ("value", "cell"), [(np.float64(2.5), 2.5), (np.int64(3), 3), (float("nan"), None), (True, "true"), (None, None)]
)
def test_cells_are_plain(value: object, cell: object) -> None:
    assert tables.plain(value) == cell


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (2.5, 2.5),
        ({"from": "search", "value": "frequency_hz"}, "frequency_hz of search"),
        ({"centres": [[1.0, 2.0]] * 6}, "6 centres"),
    ],
)
def test_parameters_are_listed_with_the_unit_of_the_plan(value: object, shown: object) -> None:
    entry = {
        "path": "modes.cv_reflex.frequency_hz",
        "value": value,
        "unit": "Hz",
        "kind": "estimate",
        "ref": "a guess",
        "range": [1.0, 3.0],
        "to": None,
        "same_as": None,
    }
    (found,) = tables.listed([entry])
    assert (found.value, found.unit, found.low, found.high, found.calibrated_to) == (shown, "Hz", 1.0, 3.0, "")
