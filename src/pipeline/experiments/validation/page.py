"""What the engine was held against, on the page: a section for each check, and what they come to together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.experiments.validation.registry import CHECKS, Check
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ()
FINDINGS = ("holds", "broken", "not installed", "told")
_DRIVERS = ("edge", "averaged")
_MISTAKE = "mistake: "


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the sections of a run that checks the engine; none of any other run.

    Arguments
    ---------
    figures : those of the checks; the options of each name its check.
    """
    checks = {name: check for name, check in CHECKS.items() if f"validation/{name}" in data.inputs}
    if not checks:
        return []
    found = [PageSection("checks", "Results of the checks", _verdict(data, checks), [_all(data, checks)])]
    for name, check in checks.items():
        shown = [_grid(data, name), _mistakes(data, name)] if name == "first_law" else [_rows_of(data, name)]
        # A picture of a comparison that was not made is an empty frame.
        made = not all(map(_absent, _rows(data, name)))
        drawn = [figure for figure in figures if made and figure.options["check"] == name]
        found.append(PageSection(name, check.title, check.text, shown, drawn))
    return found


def _verdict(data: ReportData, checks: Mapping[str, Check]) -> str:
    counts = Counter(str(row["finding"]) for name in checks for row in _rows(data, name))
    said = f"{counts['holds']} bounds hold, {counts['broken']} are broken"
    absent = [check.title for name, check in checks.items() if any(_absent(row) for row in _rows(data, name))]
    return f"{said}; not installed here, so not compared: {', '.join(absent)}." if absent else f"{said}."


def _absent(row: Mapping[str, Any]) -> bool:
    return bool(row["finding"] == "not installed")


def _all(data: ReportData, checks: Mapping[str, Check]) -> ReportTable:
    """Return what each check comes to: how many of its rows were found to be what, and the tightest of them."""
    rows: list[tuple[Cell, ...]] = []
    for name, check in checks.items():
        own = list(_rows(data, name))
        counts = Counter(str(row["finding"]) for row in own)
        used = [(_used(row), str(row["quantity"])) for row in own if row["finding"] in ("holds", "broken")]
        most, which = max(used) if used else (None, None)
        rows.append((check.title, *(counts[word] for word in FINDINGS), most, which))
    return ReportTable(
        "checks",
        "Checks",
        "Told: a number without a bound. Used: the largest share of its bound that any row takes; 1 is all of it.",
        ("check", *FINDINGS, "used", "by"),
        tuple(rows),
    )


def _used(row: Mapping[str, Any]) -> float:
    value, bound = float(row["value"]), float(row["bound"])
    least = row["relation"] == "at least"
    return (bound / value if value else float("inf")) if least else value / bound


def _rows_of(data: ReportData, name: str) -> ReportTable:
    found = list(_rows(data, name))
    noted = any(row["note"] for row in found)
    rows = tuple(
        (
            row["quantity"], plain(row["value"]), row["unit"], _bound(row), row["finding"],
            *([row["note"] or None] if noted else []),
        )
        for row in found
    )  # fmt: skip
    header = ("quantity", "value", "unit", "bound", "finding", *(["note"] if noted else []))
    return ReportTable(f"{name}_rows", "Bounds", "", header, rows)


def _bound(row: Mapping[str, Any]) -> str | None:
    return None if row["relation"] is None else f"{row['relation']} {float(row['bound']):g}"


def _grid(data: ReportData, name: str) -> ReportTable:
    """Return the residuals of the first law, a row for each battery and mode, a column for each driver."""
    found: dict[tuple[str, str], dict[str, Mapping[str, Any]]] = {}
    for row in _rows(data, name):
        if not str(row["quantity"]).startswith(_MISTAKE):
            battery, mode, driver = str(row["quantity"]).split(", ")
            found.setdefault((battery, mode), {})[driver] = row
    bounds = {driver: float(one[driver]["bound"]) for one in found.values() for driver in _DRIVERS}
    rows = tuple(
        (battery, mode, *(plain(one[driver]["value"]) for driver in _DRIVERS), _worst(one.values()))
        for (battery, mode), one in found.items()
    )
    told = "; ".join(f"{driver} at most {bound:g}" for driver, bound in bounds.items())
    return ReportTable(
        f"{name}_rows",
        "Residual over the electrical energy, battery by battery and mode by mode",
        f"Bounds: {told}.",
        ("battery", "mode", *_DRIVERS, "finding"),
        rows,
        grouped=True,
    )


def _mistakes(data: ReportData, name: str) -> ReportTable:
    rows: list[tuple[Cell, ...]] = []
    for row in _rows(data, name):
        if str(row["quantity"]).startswith(_MISTAKE):
            battery, mistake = str(row["quantity"]).removeprefix(_MISTAKE).split(", ", 1)
            caught = "caught" if row["finding"] == "holds" else "missed"
            rows.append((battery, mistake, plain(row["value"]), plain(row["bound"]), caught))
    return ReportTable(
        f"{name}_mistakes",
        "Mistakes put in",
        "The residual where the state functions are those of a battery with a mistake: it must be above the bound.",
        ("battery", "mistake", "residual", "at least", "finding"),
        tuple(rows),
        grouped=True,
    )


def _worst(rows: Any) -> str:
    return "broken" if any(row["finding"] == "broken" for row in rows) else "holds"


def _rows(data: ReportData, name: str) -> Iterator[dict[str, Any]]:
    columns = data.table(f"validation/{name}", "rows")
    for row in zip(*columns.values(), strict=True):
        yield dict(zip(columns, row, strict=True))
