"""Declared tables: a name, columns with type, unit and description; refused on write and on read if they differ."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

Kind = Literal["number", "integer", "text", "truth"]
_TYPES: dict[str, pa.DataType] = {
    "number": pa.float64(),
    "integer": pa.int64(),
    "text": pa.string(),
    "truth": pa.bool_(),
}


ELSEWHERE = 1e-6
"""How far a number may be off on a machine that rounds otherwise, as a share of the largest of its column."""
CHAOTIC = math.inf
"""That of numbers which grow a rounding error to their own size: orbits, histories of searches."""


class TableError(ValueError):
    """A table that does not match its declaration."""


@dataclass(frozen=True)
class Column:
    """One column; `unit` is the SI or field symbol, `1` for a pure number, empty for text."""

    name: str
    unit: str
    description: str
    kind: Kind = "number"
    optional: bool = False


@dataclass(frozen=True)
class Table:
    """A declared table."""

    name: str
    description: str
    columns: tuple[Column, ...]

    def schema(self) -> pa.Schema:
        """Return the Arrow schema; unit and description stand in each field's metadata."""
        fields = [
            pa.field(
                column.name,
                _TYPES[column.kind],
                nullable=column.optional,
                metadata={"unit": column.unit, "description": column.description},
            )
            for column in self.columns
        ]
        return pa.schema(fields, metadata={"table": self.name, "description": self.description})

    def plain(self) -> dict[str, Any]:
        """Return the declaration as plain data, as a plan holds it."""
        return asdict(self)

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Table:
        """Return the table that plain data declare."""
        columns = tuple(Column(**column) for column in plain["columns"])
        return cls(plain["name"], plain["description"], columns)

    def column(self, name: str) -> Column:
        """Return the declaration of one column."""
        for column in self.columns:
            if column.name == name:
                return column
        raise KeyError(f"table {self.name} has no column {name!r}")


@dataclass(frozen=True)
class TableFile:
    """A table as a step writes it.

    Arguments
    ---------
    file : its file in the step's artefact. A field in braces, as in `{search}.history.parquet`, makes it a table of
        each; the name it is declared under then carries the same field, `{search}_history`.
    table : its declaration.
    time : its column of time [s], where it has one.
    elsewhere : column, or name of a named number, perhaps with `*` -> how far it may be off on another machine, where
        that is not `ELSEWHERE`; the first that fits counts. Enters no key.
    """

    file: str
    table: Table
    time: str | None = None
    elsewhere: Mapping[str, float] = dataclasses.field(default_factory=dict, hash=False)

    def tolerance(self, name: str) -> float:
        """Return how far a column or a named number may be off on another machine."""
        return next((found for word, found in self.elsewhere.items() if fnmatchcase(name, word)), ELSEWHERE)

    def plain(self) -> dict[str, Any]:
        """Return the declaration as plain data, as a plan holds it."""
        return {"file": self.file, "table": self.table.plain(), "time": self.time}

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> TableFile:
        """Return the table file that plain data declare."""
        return cls(plain["file"], Table.of(plain["table"]), plain["time"])


def find(tables: Mapping[str, TableFile], name: str) -> TableFile | None:
    """Return the table of a name, also where a field in braces stands for a part of it; none where there is none."""
    if name in tables:
        return tables[name]
    for pattern, found in tables.items():
        matched = _field(pattern, name)
        if matched is not None:
            return replace(found, file=found.file.format(**matched))
    return None


def of_file(tables: Mapping[str, TableFile], file: str) -> TableFile | None:
    """Return the table that is written to a file of an artefact; none where it is no declared one."""
    exact = [found for found in tables.values() if found.file == file]
    fits = [found for found in tables.values() if _field(found.file, file) is not None]
    return next(iter([*exact, *fits]), None)


def _field(pattern: str, name: str) -> dict[str, str] | None:
    """Return what the one field of a pattern stands for in a name."""
    before, brace, rest = pattern.partition("{")
    field, _, after = rest.partition("}")
    if not brace or not name.startswith(before) or not name.endswith(after) or len(name) <= len(before) + len(after):
        return None
    return {field: name[len(before) : len(name) - len(after)]}


NAMED_NUMBERS = Table(
    "quantities",
    "Named numbers that a step found, a row per number",
    (
        Column("quantity", "", "name of the number", "text"),
        Column("value", "see unit", "its value; empty where there is none", optional=True),
        Column("unit", "", "unit of the value", "text"),
        Column("description", "", "what the number is", "text"),
    ),
)
"""The table in which every step writes the numbers that statements, figures and pages read by name."""
NUMBERS = {"quantities": TableFile("quantities.parquet", NAMED_NUMBERS)}
"""The entry of the table of named numbers among the tables of a step."""

FILE_NOTES = Table(
    "file_notes",
    "What a person's file was taken for, and what was done to it; no row where the values stand in no file",
    (Column("note", "", "what was found", "text"),),
)
NOTES = {"notes": TableFile("notes.parquet", FILE_NOTES)}
"""The entry of the table of notes among the tables of a step that reads a person's file."""


def numbers(elsewhere: Mapping[str, float]) -> dict[str, TableFile]:
    """Return that entry where some numbers may be further off on another machine: name, perhaps with `*` -> how far."""
    return {name: replace(found, elsewhere=elsewhere) for name, found in NUMBERS.items()}


def to_arrow(table: Table, data: Mapping[str, Any]) -> pa.Table:
    """Build an Arrow table from columns.

    Arguments
    ---------
    table : the declaration.
    data : column name -> 1-D array or list, all of one length.

    Raises
    ------
    TableError : a column missing, unknown, of another length or type, or empty where it may not be.
    """
    declared = {column.name for column in table.columns}
    if declared != set(data):
        missing, unknown = sorted(declared - set(data)), sorted(set(data) - declared)
        raise TableError(f"table {table.name}: missing columns {missing}, undeclared columns {unknown}")
    schema = table.schema()
    try:
        arrays = [pa.array(_plain(data[field.name]), type=field.type, from_pandas=field.nullable) for field in schema]
        result = pa.Table.from_arrays(arrays, schema=schema)
    except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
        raise TableError(f"table {table.name}: {error}") from error
    _check(table, result)
    return result


def write(table: Table, data: Mapping[str, Any], path: Path) -> None:
    """Write columns as Parquet (zstd), byte for byte the same for the same values."""
    # Half of the time of a small table would go to the file's opening by Arrow.
    sink = pa.BufferOutputStream()
    pq.write_table(to_arrow(table, data), sink, compression="zstd", version="2.6")
    path.write_bytes(sink.getvalue())


def read(table: Table, path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Read a table as column name -> array; raise `TableError` where it is not what was declared."""
    try:
        found = pq.read_table(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise TableError(f"{path}: not a readable Parquet file ({error})") from error
    expected = table.schema()
    if found.schema.names != expected.names or [f.type for f in found.schema] != [f.type for f in expected]:
        raise TableError(f"{path}: not a {table.name} table: has {found.schema.names}, expected {expected.names}")
    for field in expected:
        metadata = found.schema.field(field.name).metadata or {}
        if metadata.get(b"unit", b"").decode() != table.column(field.name).unit:
            raise TableError(f"{path}: column {field.name} is not in {table.column(field.name).unit}")
    _check(table, found)
    return {name: found.column(name).to_numpy(zero_copy_only=False) for name in expected.names}


def _plain(values: Any) -> Any:
    return values if isinstance(values, np.ndarray) else list(values)


def _check(table: Table, data: pa.Table) -> None:
    for column in table.columns:
        values = data.column(column.name)
        if not column.optional and values.null_count:
            raise TableError(f"table {table.name}: column {column.name} has {values.null_count} empty values")
