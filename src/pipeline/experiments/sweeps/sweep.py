"""Sweep: the summaries of all charges of all runs in; one table of them out, a row a run, and the same as CSV."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pyarrow.csv as pc
import pyarrow.parquet as pq

from pipeline.experiments.sweeps.reading import CSV, TABLE, kind_of, prefixes
from pipeline.kernel import tables
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.tables import Column, Kind, Table, TableError, TableFile
from pipeline.published import ensemble
from pipeline.published.artefacts import Unanswerable
from pipeline.published.predicates import apply
from pipeline.published.records import Statement

Summary = Mapping[str, list[Any]]
"""Columns of a charge's summary."""
Found = dict[str, tuple[Any, Column]]
"""Name of a column -> its value in a run, and how it is declared."""


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Gather the outcomes of all runs."""
    listed = settings["runs"]
    prefix = prefixes([node for run in listed for node in run["nodes"]])
    statements = {one["name"]: Statement.model_validate(one["statement"]) for one in settings["statements"]}
    rows = [_row(run["nodes"], inputs, prefix, statements) for run in listed]
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


def _row(
    nodes: Mapping[str, str], inputs: Inputs, prefix: Mapping[str, str], statements: Mapping[str, Statement]
) -> Found:
    """Return what came of the charges of a run; `nodes` says under which name each is an input."""
    summaries = {node: _summary(inputs, source) for node, source in nodes.items()}
    found = {name: one for node, own in summaries.items() for name, one in _outcomes(own, prefix[node])}
    declared = next((inputs.declared(source, "summary") for source in nodes.values()), None)
    return found if declared is None else found | dict(_met(summaries, declared, statements))


def _outcomes(summary: Summary, prefix: str) -> Iterator[tuple[str, tuple[Any, Column]]]:
    """Yield the columns that a charge fills in its run's row."""
    names = ("quantity", "value", "text", "unit", "description")
    for name, value, text, unit, description in zip(*(summary[name] for name in names), strict=True):
        kind: Kind = "number" if unit else "text"
        column = Column(f"{prefix}.{name}", unit, description, kind, optional=True)
        yield column.name, (value if unit else text or "", column)


def _met(
    summaries: Mapping[str, Summary], declared: TableFile, statements: Mapping[str, Statement]
) -> Iterator[tuple[str, tuple[Any, Column]]]:
    """Yield whether each published statement is true of a run's own numbers; nothing where they do not answer it."""
    held = {}
    for node, summary in summaries.items():
        # A number that a charge did not get to is empty.
        values = [math.nan if value is None else value for value in summary["value"]]
        held[node] = {"summary": {**summary, "value": values}}
    reader = ensemble.reader(held, {"charge": {"summary": declared}})
    for name, stated in statements.items():
        column = Column(f"met.{name}", "", f"true of the run's own numbers: {stated.says}", "truth", optional=True)
        try:
            found = stated.check is not None and apply(stated.check, reader, stated.unit).holds
        except Unanswerable:
            yield column.name, (None, column)
        else:
            yield column.name, (bool(found), column)


def _summary(inputs: Inputs, source: str) -> Summary:
    """Return the columns of a charge's summary; refuse a file that is not what was declared."""
    file = inputs.declared(source, "summary")
    if file is None:
        raise KeyError(f"{source} has no summary")
    # One of thousands: read without the machinery for data sets of many files.
    found = pq.ParquetFile(inputs[source] / file.file).read()
    if not found.schema.equals(_schema(file)):
        raise TableError(f"{inputs[source] / file.file}: not a {file.table.name} table")
    return {name: found.column(name).to_pylist() for name in found.column_names}


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
