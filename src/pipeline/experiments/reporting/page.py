"""Page: every artefact of a run in; the report's page, its card, its traces and its tables as CSV out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published.evaluate import VERDICTS
from pipeline.report import pages, traces
from pipeline.report import tables as report_tables
from pipeline.report.claims import Rests
from pipeline.report.pages import PageContent, PageFigure, PageSection, Paper, render
from pipeline.report.tables import ReportTable, report_data


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Write `index.html`, `card.json`, `traces.js` where something runs over time, and `tables/*.csv`."""
    listed = report_tables.listed(settings["parameters"])
    data = replace(report_data(settings, inputs), parameters=listed)
    found = inputs.table("verdicts", "verdicts") if "verdicts" in inputs else None
    verdicts: Mapping[str, Any] = found or {column.name: [] for column in VERDICTS.columns}
    told = inputs.table("verdicts", "answer") if "verdicts" in inputs and inputs.holds("verdicts", "answer") else {}
    cards = {card["name"]: card for card in settings["figures"]}
    figures = {name: _figure(card, inputs[f"figure/{name}"]) for name, card in cards.items()}
    shown: list[ReportTable] = []
    notes = _departure(settings["overrides"])
    sections: list[PageSection] = []
    curves: list[traces.Trace] = []
    owners: dict[str, str] = {}
    for page in map(import_module, settings["pages"]):
        own = [figures[name] for name, card in cards.items() if _owned(card, page) and not card["paper"]]
        tables, parts = _asked(page, "tables", data), _asked(page, "sections", data, own)
        shown += tables
        sections += parts
        notes += _asked(page, "notes", data)
        curves += _asked(page, "traces", data)
        owners |= {table.name: _owner(page) for table in (*tables, *(t for part in parts for t in part.tables))}
    apart = {figure.name for section in sections for figure in section.figures}
    study = settings["study"]
    content = PageContent(
        title=study["title"],
        subtitle=study["question"],
        paper=Paper(study["paper"], study["doi"], settings["captions"], settings["not_drawn"]),
        verdicts=verdicts,
        figures=[figure for name, figure in figures.items() if name not in apart],
        tables=shown,
        parameters=listed,
        command=settings["command"],
        keys={name: folder.name for name, folder in sorted(inputs.items())},
        sections=sections,
        answer=[str(sentence) for sentence in told.get("sentence", [])],
        place=settings["place"],
        hero=settings["hero"],
        rests={name: Rests(**one) for name, one in settings["rests"].items()},
        owners=owners,
        traces=len(curves),
        seed=settings["seed"],
        names={one["name"]: one["title"] for one in settings["modes"]},
        notes=[f"Battery: {settings['battery']}.", *notes],
    )
    (output.folder / "index.html").write_text(render(content), encoding="utf-8")
    text = json.dumps(pages.card(content, settings["overrides"]), ensure_ascii=False, indent=1)
    (output.folder / "card.json").write_text(f"{text}\n", encoding="utf-8")
    if curves:
        (output.folder / pages.TRACES).write_text(traces.script(curves), encoding="utf-8")
    judged = [report_tables.verdicts(verdicts)] if len(verdicts["statement"]) else []
    _write([*content.every_table(), *judged, report_tables.parameters(listed)], output.folder / "tables")


def _asked(page: ModuleType, what: str, *arguments: Any) -> list[Any]:
    """Return what an experiment has for the page; nothing where it has none of the kind."""
    make = getattr(page, what, None)
    return [] if make is None else list(make(*arguments))


def _owner(page: ModuleType) -> str:
    return page.__name__.split(".")[2]


def _owned(card: Mapping[str, Any], page: ModuleType) -> bool:
    return str(card["module"]).split(".")[2] == _owner(page)


def _departure(overrides: list[str]) -> list[str]:
    """Say in a sentence that a run is not the study's own, so that its verdicts are not taken for the paper's."""
    return [f"This run departs from the study by {', '.join(overrides)}; so do its verdicts."] if overrides else []


def _figure(card: Mapping[str, Any], folder: Path) -> PageFigure:
    name = card["name"]
    svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
    heavy = len(svg.encode()) > pages.LARGEST_SVG
    size = pages.size_of(svg)
    return PageFigure(name, card["paper"], card["title"], card["caption"], size, heavy, card["draw"], card["options"])


def _write(shown: Sequence[ReportTable], folder: Path) -> None:
    folder.mkdir()
    for table in shown:
        (folder / f"{table.name}.csv").write_text(report_tables.to_csv(table), encoding="utf-8")
