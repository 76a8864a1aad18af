"""Declared tables are refused on write and on read where they differ from the declaration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.kernel import registry, tables
from pipeline.kernel.tables import Column, Table, TableError

TABLE = Table(
    "sample",
    "a table",
    (
        Column("time_s", "s", "time"),
        Column("name", "", "a name", "text"),
        Column("gap", "V", "may be empty", optional=True),
    ),
)
DATA = {"time_s": np.arange(3.0), "name": ["a", "b", "c"], "gap": [1.0, None, 3.0]}
DECLARED = [found.table for step in registry.steps().values() for found in step.tables.values()]


def test_reads_back_what_was_written(tmp_path: Path) -> None:
    tables.write(TABLE, DATA, tmp_path / "t.parquet")
    read = tables.read(TABLE, tmp_path / "t.parquet")
    np.testing.assert_array_equal(read["time_s"], [0, 1, 2])
    assert list(read["name"]) == ["a", "b", "c"]
    np.testing.assert_array_equal(read["gap"], [1.0, np.nan, 3.0])


def test_same_values_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        tables.write(TABLE, DATA, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_fields_carry_unit_and_description(tmp_path: Path) -> None:
    tables.write(TABLE, DATA, tmp_path / "t.parquet")
    field = pq.read_schema(tmp_path / "t.parquet").field("time_s")
    assert field.metadata == {b"unit": b"s", b"description": b"time"}


@pytest.mark.parametrize(
    "data",
    [
        {name: DATA[name] for name in ("time_s", "name")},
        DATA | {"extra": [1, 2, 3]},
        DATA | {"time_s": np.arange(2.0)},
        DATA | {"time_s": ["x", "y", "z"]},
        DATA | {"name": ["a", None, "c"]},
    ],
    ids=["missing", "undeclared", "short", "text for a number", "empty where it may not be"],
)
def test_refuses_on_write(data: dict[str, object], tmp_path: Path) -> None:
    with pytest.raises(TableError, match="sample"):
        tables.write(TABLE, data, tmp_path / "t.parquet")
    assert not (tmp_path / "t.parquet").exists()


@pytest.mark.parametrize("fault", ["columns", "type", "unit", "bytes"])
def test_refuses_on_read(fault: str, tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    good = tables.to_arrow(TABLE, DATA)
    if fault == "columns":
        pq.write_table(good.drop_columns(["gap"]), path)
    elif fault == "type":
        pq.write_table(good.set_column(0, "time_s", pa.array([1, 2, 3])), path)
    elif fault == "unit":
        field = good.schema.field(0).with_metadata({"unit": "h"})
        pq.write_table(good.set_column(0, field, good.column(0)), path)
    else:
        pq.write_table(good, path)
        path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(TableError, match=r"t\.parquet"):
        tables.read(TABLE, path)


@pytest.mark.parametrize("table", DECLARED, ids=lambda table: table.name)
def test_every_declared_column_says_what_it_is(table: Table) -> None:
    assert len({column.name for column in table.columns}) == len(table.columns)
    for column in table.columns:
        assert column.description
        assert column.unit or column.kind in ("text", "truth")


def test_how_far_a_column_may_be_off_elsewhere_is_declared_and_enters_no_plan() -> None:
    found = tables.TableFile("{kind}.t.parquet", TABLE, elsewhere={"time_s": 1e-3, "g*": tables.CHAOTIC})
    assert [found.tolerance(name) for name in ("time_s", "gap", "name")] == [1e-3, tables.CHAOTIC, tables.ELSEWHERE]
    assert found.plain() == tables.TableFile("{kind}.t.parquet", TABLE).plain()
    named = tables.find({"{kind}": found}, "one")
    assert named is not None
    assert (named.file, named.tolerance("time_s")) == ("one.t.parquet", 1e-3)


def test_the_table_of_a_file_is_found() -> None:
    declared = {name: tables.TableFile(name, TABLE) for name in ("{kind}.parquet", "exact.parquet")}
    assert tables.of_file(declared, "exact.parquet") is declared["exact.parquet"]
    assert tables.of_file(declared, "other.parquet") is declared["{kind}.parquet"]
    assert tables.of_file(declared, "other.csv") is None
