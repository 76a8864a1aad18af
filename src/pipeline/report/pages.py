"""The report's page: one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

from pipeline.published.words import BASES, WORDS, counted
from pipeline.report.tables import Cell, Parameter, ReportTable, plain

TEMPLATES = Path(__file__).with_name("templates")
LARGEST_SVG = 500_000
"""Size in bytes above which a figure goes into the page as PNG; the SVG stays beside it."""


@dataclass(frozen=True)
class Paper:
    """The paper a study follows."""

    citation: str
    doi: str = ""


@dataclass(frozen=True)
class PageFigure:
    """A figure; `name` is its file name, `paper` its number there, `png` the bytes to show where the SVG is heavy.

    `draws` is the name of the module that draws it, `options` what was chosen there.
    """

    name: str
    paper: str
    title: str
    caption: str
    svg: str
    png: bytes = b""
    draws: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class PageSection:
    """A section of its own, between what the paper shows and the numbers; `name` is its place on the page."""

    name: str
    title: str
    text: str
    tables: Sequence[ReportTable] = ()
    figures: Sequence[PageFigure] = ()


@dataclass(frozen=True)
class PageContent:
    """Everything the page shows.

    Arguments
    ---------
    title, subtitle : the study and what it asks.
    paper : the paper it follows.
    verdicts : columns of the table of verdicts.
    figures, tables : in the order in which they are shown; tables with a number of the paper come first.
    parameters : every parameter with its source.
    command : what to type to make all of it again.
    keys : artefact -> key.
    sections : what has a section of its own.
    answer : what the study recommends, in sentences; the page begins with it.
    """

    title: str
    subtitle: str
    paper: Paper
    verdicts: Mapping[str, Sequence[Any]]
    figures: Sequence[PageFigure]
    tables: Sequence[ReportTable]
    parameters: Sequence[Parameter]
    command: str
    keys: Mapping[str, str]
    sections: Sequence[PageSection] = ()
    answer: Sequence[str] = ()


def render(content: PageContent) -> str:
    """Return the page as HTML; the same content gives the same bytes."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # not wanted where only names are

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters |= {
        "number": number,
        "unit": unit,
        "share": share,
        "image": image,
        "words": words,
        "prose": prose,
    }
    environment.globals |= {"meanings": WORDS, "bases": BASES}
    rows = _verdict_rows(content.verdicts)
    return environment.get_template("index.html.j2").render(
        content=content,
        verdicts=rows,
        counts=counted(content.verdicts),
        robust=any(row["robust_share"] is not None for row in rows),
        published=[table for table in content.tables if table.paper],
        tables=[table for table in content.tables if not table.paper],
        groups=table_groups,
        sections=[
            (name, list(found)) for name, found in groupby(content.parameters, lambda one: one.key.split(".")[0])
        ],
    )


def table_groups(table: ReportTable) -> list[tuple[Cell, list[tuple[Cell, ...]]]]:
    """Return the rows of a table by their first cell where it is grouped, else all under an empty one."""
    if not table.grouped:
        return [("", list(table.rows))]
    return [(name, [row[1:] for row in rows]) for name, rows in groupby(table.rows, lambda row: row[0])]


def number(value: Any, digits: int = 5) -> str:
    """Return a cell for people: numbers to a few digits with a true minus sign, nothing as a dash."""
    cell = plain(value)
    if cell is None or cell == "":
        return "–"
    if isinstance(cell, str):
        return cell
    text = f"{cell:d}" if isinstance(cell, int) else f"{cell:.0f}" if 1e5 <= abs(cell) < 1e9 else f"{cell:.{digits}g}"
    return text.replace("-", "−")


def unit(symbol: str) -> str:
    """Return a unit as it is printed; a pure number has none."""
    return "" if symbol == "1" else _symbols(symbol)


def prose(text: str) -> str:
    """Return a sentence with its units as they are printed."""
    return _symbols(text).replace(" +- ", " ± ")


def _symbols(text: str) -> str:
    text = re.sub(r"\bdegC\b", "°C", re.sub(r"\bohm\b", "Ω", text))
    return re.sub(r"\b(m|mW|C-rate)([23])\b", lambda found: found[1] + {"2": "²", "3": "³"}[found[2]], text)


def share(value: Any) -> str:
    """Return a share as a percentage."""
    cell = plain(value)
    return f"{100 * float(cell):.0f} %" if cell is not None else "–"


def words(name: str) -> str:
    """Return an identifier as words."""
    return name.replace("_", " ")


def image(figure: PageFigure) -> str:
    """Return a figure as a data URI: the SVG, or the PNG where the SVG is heavy."""
    data = figure.svg.encode()
    if figure.png and len(data) > LARGEST_SVG:
        return "data:image/png;base64," + base64.b64encode(figure.png).decode()
    return "data:image/svg+xml;base64," + base64.b64encode(data).decode()


def _verdict_rows(columns: Mapping[str, Sequence[Any]]) -> list[dict[str, Cell]]:
    rows = zip(*columns.values(), strict=True)
    return [dict(zip(columns, map(plain, row), strict=True)) for row in rows]
