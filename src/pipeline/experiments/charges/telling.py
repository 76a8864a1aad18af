"""What the terminal says at the end: what charges were to reach and did not, and which phases did not run."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.experiments.charges.tables import CHARGE
from pipeline.kernel import tables
from pipeline.kernel.publish import made
from pipeline.report.tables import Cell, ReportTable, plain
from pipeline.report.text import ended, label

_MARK = "time_to_soc_"


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield a line for each charge of a run that is in the store and missed something.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    for name, columns in made(run, "charge", CHARGE["summary"], results) if "charge" in steps else ():
        for quantity, text in zip(columns["quantity"], columns["text"], strict=True):
            if quantity == "missed" and text:
                yield f"{run['study']}/{run['name']} {name}: {text}"


def main_quantities(marks: Sequence[str]) -> list[tuple[str, str, float]]:
    """Return the quantities of a charge that a person looks at first: name, unit, factor that brings it to the unit.

    Arguments
    ---------
    marks : names of the times to the SOC marks, which come first.
    """
    return [
        *((name, "h", 1.0 / 3600.0) for name in (*marks, "end_time_s")),
        ("end_soc", "%", 100.0),
        ("peak_temperature_c", "degC", 1.0),
        ("peak_temperature_rise_k", "K", 1.0),
        ("mean_current_a", "A", 1.0),
        ("charge_efficiency", "%", 100.0),
        ("energy_efficiency", "%", 100.0),
        ("energy_drawn_wh", "Wh", 1.0),
        ("system_efficiency", "%", 100.0),
        ("time_at_voltage_limit_s", "h", 1.0 / 3600.0),
        ("time_at_supply_limit_s", "h", 1.0 / 3600.0),
    ]


def in_numbers(manifest: Mapping[str, Any], root: Path) -> list[ReportTable]:
    """Return what came of the charges of a published run: a table a comparison, a row a quantity, a column a mode.

    Arguments
    ---------
    manifest : of the run.
    root : folder to which its paths belong.
    """
    file = CHARGE["summary"].file
    listed = (one for one in manifest["artefacts"] if one["step"] == "charge" and one["file"] == file)
    paths = {one["key"]: root / one["path"] for one in listed}
    found: dict[tuple[str, str], dict[str, Path]] = {}
    for name, node in manifest["nodes"].items():
        path = paths.get(node["key"]) if node["step"] == "charge" else None
        if path is not None and path.is_file():
            kind, comparison, mode = name.split("/")
            found.setdefault((comparison, kind), {})[mode] = path
    cards = manifest["configuration"]
    return [_table(cards, *which, files) for which, files in found.items()]


def _table(cards: Mapping[str, Any], comparison: str, kind: str, files: Mapping[str, Path]) -> ReportTable:
    summaries = [_summary(path) for path in files.values()]
    names = dict.fromkeys(name for summary in summaries for name in summary)
    marks = sorted((name for name in names if name.startswith(_MARK)), key=_soc)
    rows: list[tuple[Cell, ...]] = []
    for name, unit, factor in main_quantities(marks):
        if name in names:
            values = [summary.get(name) for summary in summaries]
            scaled = (factor * value if isinstance(value, float) else value for value in values)
            rows.append((label(name, with_unit=False), unit, *scaled))
    rows.append(("Ended by", "", *(ended(str(summary.get("end_reason") or "")) for summary in summaries)))
    of = "" if kind == "charge" else ", second battery"
    titles = [str(cards["modes"][mode]["title"]) for mode in files]
    title = f"{cards['comparisons'][comparison]['title']}{of}"
    return ReportTable("numbers", title, "A dash: not reached.", ("quantity", "unit", *titles), tuple(rows))


def _summary(path: Path) -> dict[str, Cell]:
    columns = tables.read(CHARGE["summary"].table, path)
    rows = zip(columns["quantity"], columns["value"], columns["text"], strict=True)
    return {str(name): plain(text) if text else plain(value) for name, value, text in rows}


def _soc(name: str) -> float:
    return float(name.removeprefix(_MARK).removesuffix("_s"))
