"""Sweep: the summaries of all charges of all runs in; one table of them out, a row a run, and the same as CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pyarrow.csv as pc
import pyarrow.parquet as pq

from pipeline.experiments.sweeps.reading import CSV, TABLE, kind_of, prefixes
from pipeline.kernel import tables
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.tables import Column, Kind, Table, TableError, TableFile

Found = dict[str, tuple[Any, Column]]
"""Name of a column -> its value in a run, and how it is declared."""


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Gather the outcomes of all runs."""
    listed = settings["runs"]
    prefix = prefixes([node for run in listed for node in run["nodes"]])
    rows = [_row(run["nodes"], inputs, prefix) for run in listed]
    declared: dict[str, Column] = {}
    for row in rows:
        for name, (_, column) in row.items():
            declared.setdefault(name, column)
    table = Table(
        "sweep_runs",
        "The runs of a sweep, a row each: swept keys, then what came of the charge of every mode",
        (
            Column("run", "", "name of the run", "text"),
            *(_swept(key, [run["values"][place] for run in listed]) for place, key in enumerate(settings["keys"])),
            *declared.values(),
        ),
    )
    columns: dict[str, list[Any]] = {"run": [run["name"] for run in listed]}
    for place, key in enumerate(settings["keys"]):
        kind = table.column(key["key"]).kind
        columns[key["key"]] = [_plain(run["values"][place], kind) for run in listed]
    for name in declared:
        columns[name] = [row[name][0] if name in row else None for row in rows]
    tables.write(table, columns, output.folder / TABLE)
    pc.write_csv(pq.read_table(output.folder / TABLE), output.folder / CSV)


def _row(nodes: Mapping[str, str], inputs: Inputs, prefix: Mapping[str, str]) -> Found:
    """Return what came of the charges of a run; `nodes` says under which name each is an input."""
    return {name: found for node, source in nodes.items() for name, found in _outcomes(inputs, source, prefix[node])}


def _outcomes(inputs: Inputs, source: str, prefix: str) -> Iterator[tuple[str, tuple[Any, Column]]]:
    """Yield the columns that a charge fills in its run's row."""
    for name, value, text, unit, description in zip(*_summary(inputs, source), strict=True):
        kind: Kind = "number" if unit else "text"
        column = Column(f"{prefix}.{name}", unit, description, kind, optional=True)
        yield column.name, (value if unit else text or "", column)


def _summary(inputs: Inputs, source: str) -> Sequence[list[Any]]:
    """Return the columns of a charge's summary; refuse a file that is not what was declared."""
    file = inputs.declared(source, "summary")
    if file is None:
        raise KeyError(f"{source} has no summary")
    # One of thousands: read without the machinery for data sets of many files.
    found = pq.ParquetFile(inputs[source] / file.file).read()
    if not found.schema.equals(_schema(file)):
        raise TableError(f"{inputs[source] / file.file}: not a {file.table.name} table")
    return [column.to_pylist() for column in found.columns]


def _schema(file: TableFile) -> Any:
    if file.table.name not in _SCHEMAS:
        _SCHEMAS[file.table.name] = file.table.schema()
    return _SCHEMAS[file.table.name]


_SCHEMAS: dict[str, Any] = {}


def _swept(key: Mapping[str, str], values: Sequence[Any]) -> Column:
    return Column(key["key"], key["unit"], key["description"], kind_of(values), optional=True)


def _plain(value: Any, kind: str) -> Any:
    """Return a swept value as its column holds it."""
    if kind != "text" or value is None:
        return value
    return "+".join(map(str, value)) if isinstance(value, list) else str(value)
