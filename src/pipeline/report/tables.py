"""What a page is made from, and its tables: artefacts to a header and rows, for the CSV file and the page alike."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pipeline.kernel.artefacts import Columns, Inputs

Cell = str | float | int | None
JOULES_PER_WATT_HOUR = 3600.0


@dataclass(frozen=True)
class ReportTable:
    """A table of the report.

    Arguments
    ---------
    name : file name without ending, and its place on the page.
    title, caption : for people.
    header, rows : its cells; a number stays a number, an empty cell is None.
    paper : its number in the paper, where it answers one.
    grouped : whether rows with the same first cell belong together.
    """

    name: str
    title: str
    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    paper: str = ""
    grouped: bool = False

    def numeric(self) -> list[bool]:
        """Return for each column whether it holds numbers."""
        columns = zip(*self.rows, strict=True)
        found = [any(isinstance(cell, (int, float)) for cell in column) for column in columns]
        return found or [False] * len(self.header)


@dataclass(frozen=True)
class Parameter:
    """A parameter of the study and where its value comes from; `key` is the path of its name in the configuration."""

    key: str
    value: Any
    unit: str
    kind: str
    reference: str
    low: float | None = None
    high: float | None = None
    calibrated_to: str = ""


def verdicts(columns: Mapping[str, Sequence[Any]]) -> ReportTable:
    """Return the verdicts as they stand in their artefact, a row per statement."""
    rows = zip(*(columns[name] for name in columns), strict=True)
    return ReportTable(
        "verdicts", "Published statements", "", tuple(columns), tuple(tuple(map(plain, row)) for row in rows)
    )


def parameters(found: Iterable[Parameter]) -> ReportTable:
    """Return every parameter with its source, in the order of the configuration."""
    rows = [
        (one.key, plain(one.value), one.unit, one.kind, one.reference, one.low, one.high, one.calibrated_to)
        for one in found
    ]
    header = ("key", "value", "unit", "source", "reference", "low", "high", "calibrated to")
    return ReportTable("parameters", "Parameters and their sources", "", header, tuple(rows))


def listed(entries: Iterable[Mapping[str, Any]]) -> list[Parameter]:
    """Return the parameters from key path, value, unit and source as the plan holds them."""
    return [
        Parameter(
            key=entry["path"],
            value=_readable(entry["value"]),
            unit=entry["unit"],
            kind=entry["kind"],
            reference=entry["ref"],
            low=entry["range"][0] if entry["range"] else None,
            high=entry["range"][1] if entry["range"] else None,
            calibrated_to=entry["to"] or "",
        )
        for entry in entries
    ]


def _readable(value: Any) -> Any:
    if isinstance(value, Mapping):
        if "centres" in value:
            return f"{len(value['centres'])} centres"
        return f"{value['value']} of {value['from']}"
    return value


def to_csv(table: ReportTable) -> str:
    """Return a table as CSV; numbers to ten digits, so that the file is the same on every machine."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table.header)
    writer.writerows([f"{cell:.10g}" if isinstance(cell, float) else cell for cell in row] for row in table.rows)
    return out.getvalue()


def plain(value: Any) -> Cell:
    """Return a value as a cell: numpy's numbers as Python's, what is not a number as None, anything else as text."""
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or (isinstance(value, (str, float, int)) and not isinstance(value, bool)):
        return value
    if isinstance(value, (list, tuple)):
        return ", ".join(str(part) for part in value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def sentence(text: str) -> str:
    """Return a text with a capital first letter, the others as they are."""
    return text[:1].upper() + text[1:]


__all__ = ["Columns", "ModeLabel", "ReportData", "report_data"]


@dataclass(frozen=True)
class ModeLabel:
    """How a charging mode is called, and its knobs: numbers in ampere, volt, hertz, found values put in."""

    title: str
    knobs: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ReportData:
    """The artefacts of one run.

    Arguments
    ---------
    inputs : the artefacts, by the name of the input.
    modes : mode name -> label, in the order of the run; the order decides colours and line styles.
    comparisons : comparison name -> title, in the order of the run.
    settings : parts of the configuration that the experiments declare as labels; found values put in.
    parameters : every parameter with its source; figures have none.
    """

    inputs: Inputs
    modes: Mapping[str, ModeLabel]
    comparisons: Mapping[str, str]
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    parameters: Sequence[Parameter] = ()

    def table(self, source: str, name: str) -> Columns:
        """Return a table of an input as column name -> array; errors as for `Inputs.table`."""
        return self.inputs.table(source, name)

    def holds(self, source: str, name: str) -> bool:
        """Tell whether an input of this run has a table."""
        return self.inputs.holds(source, name)

    def shown(self, comparison: str | None) -> list[str]:
        """Return the comparisons a figure shows: the one asked for, or all that have a charge."""
        names = [comparison] if comparison else list(self.comparisons)
        return [name for name in names if self.charged(name)]

    def charged(self, comparison: str) -> list[str]:
        """Return the modes charged in a comparison, in the order of the run."""
        return [mode for mode in self.modes if f"charge/{comparison}/{mode}" in self.inputs]

    def charge(self, comparison: str, mode: str, name: str) -> Columns:
        """Return a table of one charge."""
        return self.table(f"charge/{comparison}/{mode}", name)

    def numbers(self, source: str) -> dict[str, float]:
        """Return the named numbers that a step found, without those that have no value."""
        return self.inputs.numbers(source)

    def quantities(self, comparison: str, mode: str) -> dict[str, float]:
        """Return the numbers of a charge's summary by name, without those it did not get to."""
        return self.inputs.numbers(f"charge/{comparison}/{mode}", "summary")


def report_data(settings: Mapping[str, Any], inputs: Inputs) -> ReportData:
    """Return the artefacts of a run under the titles of its modes and comparisons, in the order of the run."""
    labels = settings["settings"]
    knobs = labels.get("modes", {})
    modes = {one["name"]: ModeLabel(one["title"], knobs.get(one["name"], {})) for one in settings["modes"]}
    comparisons = {one["name"]: one["title"] for one in settings["comparisons"]}
    return ReportData(inputs, modes, comparisons, labels)
