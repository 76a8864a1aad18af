"""The section of the page on the second battery: where its charges answer otherwise, and both side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.experiments.charges.tables import SECOND
from pipeline.report.tables import JOULES_PER_WATT_HOUR, Cell, Columns, ReportData, ReportTable
from pipeline.report.text import rc_pair

Verdicts = Mapping[str, Any]
MARK = 0.95


def cells(data: ReportData) -> tuple[str, ...]:
    """Return the titles of the batteries, where the reader asks for them."""
    return tuple(data.settings.get("cells", {}).get("titles", ()))


def second(data: ReportData) -> ReportData:
    """Return the charges of the second battery as if they were the first's, and nothing else."""
    names = {f"charge/{name.partition('/')[2]}": name for name in data.inputs.of_kind(SECOND)}
    settings = {"cells": {"titles": cells(data)[1:]}}
    return ReportData(data.inputs.renamed(names), data.modes, data.comparisons, settings)


def differing(first: Verdicts, other: Verdicts) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return the rows of both tables for the statements whose condition one battery meets and the other does not."""
    rows = {row["statement"]: row for row in _rows(first)}
    pairs = [(rows[row["statement"]], row) for row in _rows(other)]
    return [(one, another) for one, another in pairs if one["met"] != another["met"]]


def summary(first: Verdicts, other: Verdicts, titles: Sequence[str]) -> str:
    """Return in a sentence how many statements have another outcome."""
    asked, count = len(other["statement"]), len(differing(first, other))
    if not count:
        same = f"have the same outcome with {titles[1]} as with {titles[0]}"
        return f"All {asked} statements that charges alone answer {same}."
    verb = "has" if count == 1 else "have"
    return (
        f"Of the {asked} statements that charges alone answer, {count} {verb} another outcome with {titles[1]} "
        f"than with {titles[0]}."
    )


def statements(first: Verdicts, other: Verdicts, titles: Sequence[str]) -> ReportTable:
    """Return the statements with another outcome, with what each battery's charges came to."""
    rows = [(one["says"], one["reading"], _told(one), _told(found)) for one, found in differing(first, other)]
    return ReportTable(
        "second_differs",
        "Statements with another outcome",
        "The same conditions, tested on the charges of each battery with the same modes and supply.",
        ("statement", "tested as", *titles),
        tuple(rows),
    )


def side_by_side(data: ReportData) -> ReportTable:
    """Return both batteries beside each other: time to 95 % SOC, peak rise, heat by path, mode by mode.

    Arguments
    ---------
    data : charges of both batteries.
    """
    both = (data, second(data))
    rows: list[tuple[Cell, ...]] = []
    for comparison in data.shown(None):
        for mode in data.charged(comparison):
            title = f"{data.comparisons[comparison]}: {data.modes[mode].title}"
            found = [_numbers(one, comparison, mode) for one in both]
            names = dict.fromkeys(name for one in found for name in one)
            rows += [(title, *name, *(one.get(name) for one in found)) for name in names]
    return ReportTable(
        "second_charges",
        "Both batteries, charge by charge",
        "A dash: not reached, or the battery has no such part.",
        ("charge", "quantity", "unit", *cells(data)),
        tuple(rows),
        grouped=True,
    )


def _numbers(data: ReportData, comparison: str, mode: str) -> dict[tuple[str, str], Cell]:
    if mode not in data.charged(comparison):
        return {}
    found = data.quantities(comparison, mode)
    heat = _heat(data.charge(comparison, mode, "energy"))
    numbers: dict[tuple[str, str], Cell] = {
        (f"time to {100 * MARK:g} % SOC", "h"): _hours(found.get(f"time_to_soc_{MARK:g}_s")),
        ("SOC at the end", "%"): 100 * found["end_soc"] if "end_soc" in found else None,
        ("peak temperature rise", "K"): found.get("peak_temperature_rise_k"),
        ("energy efficiency, into the battery", "%"): _per_cent(found.get("energy_efficiency")),
        ("energy efficiency, over all drawn", "%"): _per_cent(found.get("system_efficiency")),
        ("heat, all paths", "Wh"): sum(heat.values()),
    }
    return numbers | {(f"heat: {rc_pair(path)}", "Wh"): energy for path, energy in heat.items()}


def _heat(energy: Columns) -> dict[str, float]:
    """Return the losses by path [Wh], those that are none left out."""
    lost = energy["role"] == "loss"
    parts = zip(energy["path"][lost], energy["energy_j"][lost], strict=True)
    return {str(path): float(joule) / JOULES_PER_WATT_HOUR for path, joule in parts if joule}


def _per_cent(share: float | None) -> float | None:
    return None if share is None else 100 * share


def _hours(seconds: float | None) -> float | None:
    return None if seconds is None else seconds / 3600.0


def _rows(columns: Verdicts) -> list[dict[str, Any]]:
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _told(row: Mapping[str, Any]) -> str:
    word = {"yes": "met", "no": "not met"}.get(str(row["met"]), "no answer")
    return f"{word}: {row['explanation']}"
