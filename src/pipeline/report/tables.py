"""The report's tables: from artefacts to a header and rows, which become a CSV file and a table of the page alike."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.report.data import Columns, ReportData

Cell = str | float | int | None
JOULES_PER_WATT_HOUR = 3600.0
_STANDARD = (1000.0, 25.0)
_TABLE_1 = (
    ("maximum power", "W", "p_max_w", "max_power_w"),
    ("voltage at maximum power", "V", "v_mp_v", "max_power_voltage_v"),
    ("current at maximum power", "A", "i_mp_a", "max_power_current_a"),
    ("open-circuit voltage", "V", "v_oc_v", "open_circuit_voltage_v"),
    ("short-circuit current", "A", "i_sc_a", "short_circuit_current_a"),
)


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


def table_1(data: ReportData, printed: Path) -> ReportTable:
    """Return the panel's characteristic values, printed and computed.

    Arguments
    ---------
    data : artefacts, of which `panel` is read.
    printed : CSV file with the paper's Table 1.
    """
    with printed.open(encoding="utf-8", newline="") as file:
        paper = next(csv.DictReader(file))
    points = data.table("panel", "points")
    conditions = zip(points["irradiance_w_m2"], points["cell_temperature_c"], strict=True)
    row = next((place for place, found in enumerate(conditions) if found == _STANDARD), None)
    rows = []
    for title, unit, theirs, ours in _TABLE_1:
        value = float(paper[theirs])
        computed = None if row is None else float(points[ours][row])
        deviation = None if computed is None else 100.0 * (computed / value - 1.0)
        rows.append((title, unit, value, computed, deviation))
    return ReportTable(
        "table_1",
        "Panel at 1000 W/m² and 25 °C",
        "The single-diode model is fitted to the voltages and currents, so these agree by construction; "
        "the power is their product.",
        ("quantity", "unit", "printed", "computed", "deviation / %"),
        tuple(rows),
        paper="Table 1",
    )


def charges(data: ReportData) -> ReportTable:
    """Return every quantity of the charges' summaries: a row per comparison and quantity, a column per mode."""
    rows: list[tuple[Cell, ...]] = []
    for comparison in data.shown(None):
        summaries = {mode: data.charge(comparison, mode, "summary") for mode in data.charged(comparison)}
        units = {
            str(n): str(u) for one in summaries.values() for n, u in zip(one["quantity"], one["unit"], strict=True)
        }
        found = {mode: _summary(one) for mode, one in summaries.items()}
        for quantity, unit in units.items():
            cells = tuple(found[mode].get(quantity) if mode in found else None for mode in data.modes)
            rows.append((data.comparisons[comparison], quantity, unit, *cells))
    return ReportTable(
        "charges",
        "What came of the charges",
        "An empty cell: the charge did not get there.",
        ("comparison", "quantity", "unit", *(label.title for label in data.modes.values())),
        tuple(rows),
        grouped=True,
    )


def energy(data: ReportData) -> ReportTable:
    """Return where the energy of each charge went [Wh]: a row per comparison and path, a column per mode."""
    rows: list[tuple[Cell, ...]] = []
    for comparison in data.shown(None):
        found = {mode: data.charge(comparison, mode, "energy") for mode in data.charged(comparison)}
        paths = {
            str(path): str(role) for one in found.values() for path, role in zip(one["path"], one["role"], strict=True)
        }
        values = {
            mode: dict(zip(map(str, one["path"]), one["energy_j"].tolist(), strict=True)) for mode, one in found.items()
        }
        for path, role in paths.items():
            joules = [values.get(mode, {}).get(path) for mode in data.modes]
            watt_hours = (None if one is None else one / JOULES_PER_WATT_HOUR for one in joules)
            rows.append((data.comparisons[comparison], path, role, *watt_hours))
    return ReportTable(
        "energy",
        "Where the energy went [Wh]",
        "Input less everything stored, lost and given off leaves the residual: the first law, closed.",
        ("comparison", "path", "role", *(label.title for label in data.modes.values())),
        tuple(rows),
        grouped=True,
    )


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


def _summary(columns: Columns) -> dict[str, Cell]:
    rows = zip(columns["quantity"], columns["value"], columns["text"], strict=True)
    return {str(name): plain(text) if text else plain(value) for name, value, text in rows}


def sentence(text: str) -> str:
    """Return a text with a capital first letter, the others as they are."""
    return text[:1].upper() + text[1:]
