"""Tables of the report, from artefacts to CSV."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from pipeline.report import tables
from pipeline.report.data import ReportData
from tests.report_pages.conftest import verdict_columns

PRINTED = "p_max_w,v_mp_v,i_mp_a,v_oc_v,i_sc_a\n60,17.4,3.75,21.7,3.99\n"


def test_table_1_sets_the_computed_beside_the_printed(data: ReportData, tmp_path: Path) -> None:
    printed = tmp_path / "printed.csv"
    printed.write_text(PRINTED, encoding="utf-8")
    rows = tables.table_1(data, printed).rows
    assert rows[0] == ("maximum power", "W", 60.0, 65.25, pytest.approx(8.75))
    assert [row[4] for row in rows[1:]] == [0.0, 0.0, 0.0, 0.0]


def test_a_charge_that_did_not_get_there_or_was_not_made_leaves_its_cell_empty(data: ReportData) -> None:
    table = tables.charges(data)
    assert table.header == ("comparison", "quantity", "unit", "CC-CV", "CV-Reflex")
    assert table.rows[0] == ("Same peak current", "time_to_soc_0.95_s", "s", 9000.0, None)
    assert table.rows[1][3] == "stop: elapsed 43200 s"
    assert table.rows[2] == ("Same mean current", "time_to_soc_0.95_s", "s", 9000.0, None)
    assert table.numeric() == [False, False, False, True, False]


def test_energy_is_told_in_watt_hours(data: ReportData) -> None:
    rows = tables.energy(data).rows
    assert rows[:2] == (
        ("Same peak current", "electrical input", "input", 10.0, 10.0),
        ("Same peak current", "series resistance", "loss", 0.5, 0.5),
    )
    assert rows[2][3:] == (10.0, None)


def test_csv_reads_back(data: ReportData) -> None:
    table = tables.ReportTable("t", "", "", ("a", "b"), (('x, "y"', 1 / 3), (None, 2.0)))
    assert list(csv.reader(io.StringIO(tables.to_csv(table)))) == [["a", "b"], ['x, "y"', "0.3333333333"], ["", "2"]]


def test_verdicts_keep_every_column(data: ReportData) -> None:
    columns = verdict_columns("holds", "fails")
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
