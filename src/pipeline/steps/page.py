"""Page: every artefact of a run in; the report's page and its tables as CSV out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, tables
from pipeline.published.reference import REFERENCE
from pipeline.report import day_tables, second_cell, supply_sections
from pipeline.report import tables as report_tables
from pipeline.report.data import ReportData
from pipeline.report.function_tables import function_tables
from pipeline.report.missed import missed
from pipeline.report.network_tables import network_tables
from pipeline.report.pages import PageContent, PageFigure, PageSection, Paper, render
from pipeline.report.parameters import parameters
from pipeline.report.search_tables import beyond_range, search_tables
from pipeline.report.staging_tables import staging_tables
from pipeline.report.switched_tables import switched_tables
from pipeline.report.tables import ReportTable
from pipeline.report.validation_tables import validation_sections
from pipeline.report.worth import answer, titles, worth
from pipeline.steps.labels import report_data


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Write `index.html` and `tables/*.csv`."""
    data = report_data(settings, inputs)
    verdicts = _verdicts(inputs)
    shown = _tables(data, inputs)
    figures = {card["name"]: _figure(card, inputs[f"figure/{card['name']}"]) for card in settings["figures"]}
    parts = ("second_charge", "trade_off", "validation", "tracking", "converters", "day")
    of = {part: _reading(settings["figures"], part) for part in parts}
    drawn = {part: [figures[name] for name in names] for part, names in of.items()}
    apart = {name for names in of.values() for name in names}
    sections = _worth(data, inputs, drawn["trade_off"])
    sections += _second(data, inputs, verdicts, drawn["second_charge"])
    sections += validation_sections(data, settings.get("checks", ()), _by_check(settings["figures"], figures))
    sections += supply_sections.sections(data, drawn["tracking"], drawn["converters"])
    sections += _days(data, drawn["day"])
    listed = parameters(settings["parameters"])
    study, searched = settings["study"], settings.get("searched")
    notes = [
        *_departure(settings["overrides"]),
        *missed(data),
        *beyond_range(data, tuple(searched) if searched else None),
    ]
    page = PageContent(
        title=study["title"],
        subtitle=" ".join([f"{study['question']} {settings['battery']}.", *notes]),
        paper=Paper(study["paper"], study["doi"]),
        verdicts=verdicts,
        figures=[figure for name, figure in figures.items() if name not in apart],
        tables=shown,
        parameters=listed,
        command=settings["command"],
        keys={name: folder.name for name, folder in sorted(inputs.items())},
        sections=sections,
    )
    (output / "index.html").write_text(render(page), encoding="utf-8")
    (output / "tables").mkdir()
    in_sections = [table for section in sections for table in section.tables]
    judged = [report_tables.verdicts(verdicts)] if len(verdicts["statement"]) else []
    for table in [*shown, *in_sections, *judged, report_tables.parameters(listed)]:
        (output / "tables" / f"{table.name}.csv").write_text(report_tables.to_csv(table), encoding="utf-8")


def _departure(overrides: list[str]) -> list[str]:
    """Say in a sentence that a run is not the study's own, so that its verdicts are not taken for the paper's."""
    return [f"This run departs from the study by {', '.join(overrides)}; so do its verdicts."] if overrides else []


def _tables(data: ReportData, inputs: Mapping[str, Path]) -> list[ReportTable]:
    shown = [report_tables.charges(data), report_tables.energy(data)] if _charged(inputs) else []
    if "panel" in inputs:
        shown.insert(0, report_tables.table_1(data, REFERENCE / "solar_table1.csv"))
    shown += switched_tables(data) + search_tables(data, REFERENCE) + network_tables(data, REFERENCE)
    return shown + staging_tables(data) + function_tables(data)


def _charged(inputs: Mapping[str, Path]) -> bool:
    return any(name.startswith("charge/") for name in inputs)


def _by_check(cards: list[Mapping[str, Any]], figures: Mapping[str, PageFigure]) -> dict[str, list[PageFigure]]:
    """Return the figures of each check of the engine."""
    found: dict[str, list[PageFigure]] = {}
    for card in cards:
        if "validation" in card["reads"]:
            found.setdefault(card["options"]["check"], []).append(figures[card["name"]])
    return found


def _reading(cards: list[Mapping[str, Any]], step: str) -> list[str]:
    """Return the names of the figures of a section of its own: those that show a step above all."""
    return [card["name"] for card in cards if step in card["reads"] and not card["paper"]]


def _worth(data: ReportData, inputs: Mapping[str, Path], figures: list[PageFigure]) -> list[PageSection]:
    """Return the section on what the network is worth; none where the run does not weigh it."""
    if "trade_off" not in inputs:
        return []
    text = answer(data.numbers("trade_off"), titles(data))
    return [PageSection("is-it-worth-it", "Is the network worth it?", text, [worth(data)], figures)]


def _second(
    data: ReportData, inputs: Mapping[str, Path], verdicts: Mapping[str, Any], figures: list[PageFigure]
) -> list[PageSection]:
    """Return the section on the second battery; none where the run has one battery."""
    if len(data.cells) < 2:
        return []
    others = _verdicts(inputs, "second")
    shown = [second_cell.side_by_side(data)]
    if second_cell.differing(verdicts, others):
        shown.insert(0, second_cell.statements(verdicts, others, data.cells))
    text = second_cell.summary(verdicts, others, data.cells)
    return [PageSection("second-cell", "Where the second cell differs", text, shown, figures)]


def _days(data: ReportData, figures: list[PageFigure]) -> list[PageSection]:
    """Return the section on days in the sun; none where the run has none."""
    if not day_tables.weathers(data):
        return []
    shown = [day_tables.numbers(data), day_tables.switchings(data), *day_tables.gaps(data)]
    title = f"From sun to battery: {data.settings['day']['title']}"
    return [PageSection("days-in-the-sun", title, day_tables.text(data), shown, figures)]


def _verdicts(inputs: Mapping[str, Path], name: str = "verdicts") -> dict[str, Any]:
    if "verdicts" not in inputs:
        return {column.name: [] for column in schemas.VERDICTS.columns}
    return tables.read(schemas.VERDICTS, inputs["verdicts"] / f"{name}.parquet")


def _figure(card: Mapping[str, Any], folder: Path) -> PageFigure:
    name = card["name"]
    svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
    return PageFigure(name, card["paper"], card["title"], card["caption"], svg, (folder / f"{name}.png").read_bytes())
