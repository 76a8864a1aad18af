"""Page: every artefact of a run in; the report's page and its tables as CSV out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, tables
from pipeline.digest import PROJECT
from pipeline.report import tables as report_tables
from pipeline.report.data import ReportData
from pipeline.report.function_tables import function_tables
from pipeline.report.pages import PageContent, PageFigure, Paper, render
from pipeline.report.parameters import parameters
from pipeline.report.search_tables import search_tables
from pipeline.report.staging_tables import staging_tables
from pipeline.report.tables import ReportTable
from pipeline.steps.labels import report_data

REFERENCE = PROJECT / "conf" / "published" / "reference"


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Write `index.html` and `tables/*.csv`."""
    data = report_data(settings, inputs)
    verdicts = _verdicts(inputs)
    shown = _tables(data, inputs)
    listed = parameters(settings["parameters"])
    study = settings["study"]
    page = PageContent(
        title=study["title"],
        subtitle=" ".join([f"{study['question']} {settings['battery']}.", *_departure(settings["overrides"])]),
        paper=Paper(study["paper"], study["doi"]),
        verdicts=verdicts,
        figures=[_figure(card, inputs[f"figure/{card['name']}"]) for card in settings["figures"]],
        tables=shown,
        parameters=listed,
        command=settings["command"],
        keys={name: folder.name for name, folder in sorted(inputs.items())},
    )
    (output / "index.html").write_text(render(page), encoding="utf-8")
    (output / "tables").mkdir()
    for table in [*shown, report_tables.verdicts(verdicts), report_tables.parameters(listed)]:
        (output / "tables" / f"{table.name}.csv").write_text(report_tables.to_csv(table), encoding="utf-8")


def _departure(overrides: list[str]) -> list[str]:
    """Say in a sentence that a run is not the study's own, so that its verdicts are not taken for the paper's."""
    return [f"This run departs from the study by {', '.join(overrides)}; so do its verdicts."] if overrides else []


def _tables(data: ReportData, inputs: Mapping[str, Path]) -> list[ReportTable]:
    shown = [report_tables.charges(data), report_tables.energy(data)]
    if "panel" in inputs:
        shown.insert(0, report_tables.table_1(data, REFERENCE / "solar_table1.csv"))
    return shown + search_tables(data, REFERENCE) + staging_tables(data) + function_tables(data)


def _verdicts(inputs: Mapping[str, Path]) -> dict[str, Any]:
    if "verdicts" not in inputs:
        return {column.name: [] for column in schemas.VERDICTS.columns}
    return tables.read(schemas.VERDICTS, inputs["verdicts"] / "verdicts.parquet")


def _figure(card: Mapping[str, Any], folder: Path) -> PageFigure:
    name = card["name"]
    svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
    return PageFigure(name, card["paper"], card["title"], card["caption"], svg, (folder / f"{name}.png").read_bytes())
