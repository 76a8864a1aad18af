"""The page of a run: HTML with its style and scripts in it; figures and traces are files beside it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.published.wording import of_differences
from pipeline.published.words import BASES, WORDS, counted
from pipeline.report import text
from pipeline.report.claims import AS_STATED, Rests, claims, count_bar, matrix
from pipeline.report.tables import Parameter, ReportTable, sentence
from pipeline.report.traces import MOST_POINTS

TEMPLATES = Path(__file__).with_name("templates")
LARGEST_SVG = 500_000
"""Size in bytes above which the page shows a figure as PNG; the SVG stays beside it."""
FOLDED = 14
"""Rows above which a table is folded until somebody wants it."""
TRACES = "traces.js"
"""The script of the curves over time, beside the page."""
ON_TOP = ("calibrated", "fitted")
"""Sources of parameters that the page shows first."""
_GROUPS = ("Studies", "Other runs", "Sweeps", "Modes side by side")
SIDE_BY_SIDE = "compare_modes"
"""Folder below `reports/` of the pages of `python -m pipeline compare-modes`; they belong to no run."""
_POINTS_PER_PIXEL = 0.75


@dataclass(frozen=True)
class Paper:
    """The paper a study follows.

    Arguments
    ---------
    captions : its own captions, by `Figure 11` or `Table 2`.
    not_drawn : why the page has no figure or table for one of its own, by the same names.
    """

    citation: str
    doi: str = ""
    captions: Mapping[str, str] = field(default_factory=dict)
    not_drawn: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class PageFigure:
    """A figure; `name` is its file name, `paper` its number there, `heavy` whether the PNG is to be shown.

    `size` are width and height in pixels, `draws` is the name of the module that draws it, `options` what was chosen
    there.
    """

    name: str
    paper: str
    title: str
    caption: str
    size: tuple[int, int] = (864, 432)
    heavy: bool = False
    draws: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def file(self) -> str:
        """Return the file that the page shows, from beside it."""
        return f"figures/{self.name}.{'png' if self.heavy else 'svg'}"

    @property
    def heading(self) -> str:
        """Return its number in the paper and its title."""
        return f"{self.paper} {self.title}" if self.paper else self.title


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
    figures, tables : in the order in which they are shown; those with a number of the paper come first.
    parameters : every parameter with its source.
    command : what to type to make all of it again.
    keys : artefact -> key.
    sections : what has a section of its own.
    answer : what the study recommends, in sentences; the page begins with it.
    place : folder of the run below `reports/`, and below `results/`.
    hero : name of the figure that shows the answer.
    rests : statement -> what its answer rests on.
    owners : table -> the experiment that shows it.
    traces : how many curves over time lie beside the page.
    seed : root of the random streams.
    notes : what else there is to say of this run.
    names : words of identifiers -> how people write them; the modes.
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
    place: str = ""
    hero: str = ""
    rests: Mapping[str, Rests] = field(default_factory=dict)
    owners: Mapping[str, str] = field(default_factory=dict)
    traces: int = 0
    seed: int | None = None
    notes: Sequence[str] = ()
    names: Mapping[str, str] = field(default_factory=dict)

    def every_figure(self) -> list[PageFigure]:
        """Return the figures in the order of the page."""
        return [*self.figures, *(figure for one in self.sections for figure in one.figures)]

    def every_table(self) -> list[ReportTable]:
        """Return the tables in the order of the page."""
        return [*self.tables, *(table for one in self.sections for table in one.tables)]

    def shown_first(self) -> PageFigure | None:
        """Return the figure that shows the answer: the one asked for, else the first."""
        found = self.every_figure()
        return next((figure for figure in found if figure.name == self.hero), next(iter(found), None))


class TableView(NamedTuple):
    """A table as it is printed: header, whether each column holds numbers, and rows of cells by group."""

    header: list[str]
    numeric: list[bool]
    groups: list[tuple[str, list[tuple[text.Printed, ...]]]]
    rows: int


def render(content: PageContent) -> str:
    """Return the page as HTML; the same content gives the same bytes."""
    figures = {one.name: (one.paper, one.title) for one in content.every_figure()}
    tables = [(content.owners.get(table.name, ""), table) for table in content.every_table()]
    found = claims(content.verdicts, content.rests, figures, tables, content.names)
    counts = counted(content.verdicts)
    on_top = [one for one in content.parameters if one.kind in ON_TOP]
    page = environment().get_template("index.html.j2")
    html: str = page.render(
        content=content,
        claims=found,
        statements=[one.name for claim in found for one in claim.verdicts],
        matrix=matrix(found),
        counts=counts | {"all": Counter(str(word) for word in content.verdicts["verdict"])},
        bar=count_bar(counts["statements"]),
        as_stated=AS_STATED,
        close_calls=sum(bool(one.close) for claim in found for one in claim.verdicts),
        published=[table for table in content.tables if table.paper],
        tables=[table for table in content.tables if not table.paper],
        in_order=_in_order(content),
        hero=content.shown_first(),
        on_top=on_top,
        groups=_by_part(content.parameters),
    )
    return html


def front(reports: Sequence[Mapping[str, Any]]) -> str:
    """Return the page that leads to all others.

    Arguments
    ---------
    reports : what `card` returned for each, with its `place` below `reports/`, and under `run` whether the script that
        tells of the run is there; the studies' own come first. A run that the study's own page was made from, as it
        departs in the same and came to the same, has no card beside it.
    """
    reports = [one for one in reports if not any(_made_from(other, one) for other in reports)]
    groups = [(title, [one for one in reports if _group(one) == title]) for title in _GROUPS]
    places = [one["place"] for one in reports if one["run"]]
    shown = [(title, found) for title, found in groups if found]
    return str(environment().get_template("front.html.j2").render(groups=shown, places=places))


def card(content: PageContent, departs: Sequence[str] = ()) -> dict[str, Any]:
    """Return what the front page shows of a run.

    Arguments
    ---------
    departs : the words that make it another run than the study's own.
    """
    hero = content.shown_first()
    counts = counted(content.verdicts)
    first = next((one.text for one in content.sections), "")
    return short_card(
        content.title,
        content.subtitle,
        content.answer[0] if content.answer else first,
        None if hero is None else (hero.file, hero.size),
    ) | {"counts": counts["statements"], "departs": list(departs)}


def short_card(
    title: str, question: str, answer: str = "", picture: tuple[str, tuple[int, int]] | None = None
) -> dict[str, Any]:
    """Return what the front page shows of a page without verdicts.

    Arguments
    ---------
    picture : its file, from beside the page, and its width and height in pixels.
    """
    shown = None if picture is None else {"file": picture[0], "size": picture[1]}
    return {"title": title, "question": question, "answer": answer, "counts": [], "picture": shown, "departs": []}


def view(table: ReportTable) -> TableView:
    """Return a table as it is printed: names as words, decimal points in one line, grouped rows under a heading."""
    with_unit = "unit" not in table.header
    columns = [
        text.column(cells) if numeric else _labels(cells, with_unit)
        for cells, numeric in zip(zip(*table.rows, strict=True), table.numeric(), strict=False)
    ]
    if not with_unit and columns:
        place = table.header.index("unit")
        columns[place] = [cell._replace(text=text.unit(cell.text)) for cell in columns[place]]
    columns = [[cell._replace(text=text.symbols(text.spelt(cell.text))) for cell in cells] for cells in columns]
    rows = list(zip(*columns, strict=True))
    header, numeric = [text.symbols(text.label(name)) for name in table.header], table.numeric()
    if not table.grouped:
        return TableView(header, numeric, [("", rows)], len(rows))
    groups = [(name, [row[1:] for row in own]) for name, own in groupby(rows, lambda row: row[0].text)]
    return TableView(header[1:], numeric[1:], groups, len(rows))


def _labels(cells: Sequence[Any], with_unit: bool) -> list[text.Printed]:
    """Return the cells of a column of words; where one is a name, all begin with a capital letter."""
    shown = [text.label(cell, with_unit) for cell in cells]
    named = any(map(text.is_name, cells))
    return [text.Printed(sentence(one) if named else one) for one in shown]


def size_of(svg: str) -> tuple[int, int]:
    """Return width and height of a drawing in pixels, as its head gives them; a usual size where it does not."""
    found = [re.search(rf'<svg[^>]*\b{side}="([\d.]+)(pt)?"', svg) for side in ("width", "height")]
    if not all(found):
        return (864, 432)
    width, height = (float(one[1]) / (_POINTS_PER_PIXEL if one[2] else 1.0) for one in found if one)
    return (round(width), round(height))


def _group(report: Mapping[str, Any]) -> str:
    """Return under which title of the front page a report stands."""
    studies, other, sweeps, side_by_side = _GROUPS
    if report["place"].startswith(f"{SIDE_BY_SIDE}/"):
        return side_by_side
    if report["place"].count("/") > 1:
        return sweeps
    own = not report["departs"] or report["place"].endswith("/default")
    return studies if report["counts"] and own else other


def _made_from(own: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Tell whether a study's own page shows another run, which was made before: the same card at another place."""
    study, _, run = own["place"].partition("/")
    same = all(own[name] == other[name] for name in own if name not in ("place", "run"))
    return run == "default" and own is not other and other["place"].startswith(f"{study}/") and same


def _by_part(parameters: Sequence[Parameter]) -> list[tuple[str, list[Parameter]]]:
    found: dict[str, list[Parameter]] = {}
    for one in parameters:
        found.setdefault(one.key.split(".")[0], []).append(one)
    return list(found.items())


LEFT_OUT = "this run leaves out what it shows"
"""Why a figure of the paper is not there where nobody says otherwise: a run of other modes, say."""


class Absent(NamedTuple):
    """A figure or table of the paper that the page has none for; `paper` is its number there."""

    paper: str
    why: str
    title: str = "not drawn"

    @property
    def name(self) -> str:
        """Return the identifier of its place on the page."""
        return f"absent-{self.paper.lower().replace(' ', '-')}"


def _in_order(content: PageContent) -> list[PageFigure | Absent]:
    """Return the figures of the page, and before the next number of the paper what it has none for."""
    paper = content.paper
    shown = {one.paper for one in content.every_figure()} | {one.paper for one in content.every_table()}
    found: list[PageFigure | Absent] = [*content.figures]
    for number in dict.fromkeys([*paper.captions, *paper.not_drawn]):
        if number not in shown:
            later = (place for place, one in enumerate(found) if _number(one.paper) > _number(number))
            found.insert(next(later, len(found)), Absent(number, paper.not_drawn.get(number, LEFT_OUT)))
    return found


def _number(paper: str) -> float:
    """Return the number of a figure of the paper; that of a table lies behind them all, and that of our own before."""
    kind, _, number = paper.partition(" ")
    return 0.0 if not paper else float(number) if kind == "Figure" and number.isdecimal() else math.inf


def environment(*more: Path) -> Any:
    """Return what renders the templates here, and those in other folders that include them."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # not wanted where only names are

    found = Environment(
        loader=FileSystemLoader([TEMPLATES, *more]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    found.filters |= {
        "number": text.number,
        "unit": text.unit,
        "apart": of_differences,
        "share": text.share,
        "shell": text.shell,
        "words": text.words,
        "prose": text.prose,
        "view": view,
        "sentence": sentence,
        "slug": lambda word: str(word).replace(" ", "-"),
        "bar": count_bar,
    }
    found.globals |= {
        "meanings": WORDS,
        "bases": BASES,
        "folded": FOLDED,
        "traces_file": TRACES,
        "side_by_side": f"{SIDE_BY_SIDE}/",
        "most_points": MOST_POINTS,
    }
    return found
