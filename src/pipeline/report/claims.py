"""Verdicts by claim: what a paper says once, in all of its readings, and what each answer rests on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.published.words import BASES, ENOUGH, WORDS
from pipeline.report.tables import Cell, ReportTable, plain
from pipeline.report.text import spelt, words

CLOSE, CLOSE_OF_ALLOWED = 0.01, 0.1
"""Share of a computed value, and where a tolerance is given of that, below which its margin is a close call."""
AS_STATED = "as stated"


@dataclass(frozen=True)
class Rests:
    """What an answer rests on.

    Arguments
    ---------
    artefacts : what the predicate reads.
    figures : names of the figures that show it.
    owners : experiments that make the artefacts; their tables show them.
    parameters : parts of the configuration behind it.
    fitted : key paths behind it that were calibrated or fitted.
    file, key : where the statement is written.
    command : what to type to compute it again.
    title : what the statement is called; its identifier in words where it has none.
    """

    artefacts: Sequence[str] = ()
    figures: Sequence[str] = ()
    owners: Sequence[str] = ()
    parameters: Sequence[str] = ()
    fitted: Sequence[str] = ()
    file: str = ""
    key: str = ""
    command: str = ""
    title: str = ""


@dataclass(frozen=True)
class Verdict:
    """A row of the list of verdicts: its columns, how its reading is called, and where it leads."""

    row: Mapping[str, Cell]
    reading: str = AS_STATED
    close: str = ""
    rests: Rests = field(default_factory=Rests)
    figures: Sequence[tuple[str, str]] = ()
    tables: Sequence[tuple[str, str]] = ()

    @property
    def name(self) -> str:
        """Return the identifier of the statement."""
        return str(self.row["statement"])

    @property
    def word(self) -> str:
        """Return the verdict."""
        return str(self.row["verdict"])


@dataclass(frozen=True)
class Claim:
    """What a paper says, in its words, with the verdict on every reading of it; `name` is what their names share."""

    name: str
    says: str
    where: str
    verdicts: Sequence[Verdict]

    @property
    def basis(self) -> str:
        """Return what the answers rest on, in words; that of the first reading stands for the others."""
        return BASES[str(self.verdicts[0].row["basis"])]

    def at(self, reading: str) -> Sequence[Verdict]:
        """Return the verdicts of a reading."""
        return [one for one in self.verdicts if one.reading == reading]


def claims(
    columns: Mapping[str, Sequence[Any]],
    rests: Mapping[str, Rests],
    figures: Mapping[str, tuple[str, str]],
    tables: Sequence[tuple[str, ReportTable]],
    names: Mapping[str, str] | None = None,
) -> list[Claim]:
    """Return the claims in the order of their first readings.

    Arguments
    ---------
    columns : the table of verdicts.
    rests : statement -> what its answer rests on.
    figures : name -> number in the paper and title.
    tables : experiment and table, in the order of the page.
    names : words in identifiers, `cc_cv` say -> how people write them.
    """
    rows = [dict(zip(columns, map(plain, row), strict=True)) for row in zip(*columns.values(), strict=True)]
    rows = [row | {"explanation": spelt(called(str(row["explanation"]), _identifiers(names or {})))} for row in rows]
    by_says: dict[str, list[dict[str, Cell]]] = {}
    for row in rows:
        by_says.setdefault(str(row["says"]), []).append(row)
    found = []
    for says, group in by_says.items():
        identifiers = [str(row["statement"]) for row in group]
        titles = [rests.get(name, Rests()).title for name in identifiers]
        readings = [
            own or _written(reading, names or {}) for own, reading in zip(titles, _readings(identifiers), strict=True)
        ]
        own = [
            _verdict(row, reading, rests.get(name, Rests()), figures, tables)
            for name, row, reading in zip(identifiers, group, readings, strict=True)
        ]
        if len(group) == 1:
            own = [replace(own[0], reading=AS_STATED)]
        title = (len(group) == 1 and titles[0]) or _written(_title(identifiers), names or {})
        found.append(Claim(title[:1].upper() + title[1:], says, str(group[0]["where"]), own))
    return found


def _identifiers(names: Mapping[str, str]) -> dict[str, str]:
    """Return the names that cannot be taken for a word of a sentence."""
    return {word: title for word, title in names.items() if "_" in word}


def readings(found: Iterable[Claim]) -> list[str]:
    """Return the readings that more than one claim has, that of the words themselves first."""
    counts = Counter(one.reading for claim in found for one in claim.verdicts)
    return [AS_STATED, *(name for name, count in counts.items() if count > 1 and name != AS_STATED)]


def matrix(found: Sequence[Claim]) -> list[tuple[str, list[str], list[tuple[Claim, list[Sequence[Verdict]]]]]]:
    """Return for each basis its readings, and its claims with their verdicts by reading; odd ones in rows apart."""
    groups: dict[str, list[Claim]] = {}
    for claim in found:
        groups.setdefault(claim.basis, []).append(claim)
    tables: list[tuple[str, list[str], list[tuple[Claim, list[Sequence[Verdict]]]]]] = []
    for basis, own in groups.items():
        columns = readings(own)
        rows: list[tuple[Claim, list[Sequence[Verdict]]]] = []
        for claim in own:
            cells = [claim.at(name) for name in columns]
            rows += [(claim, cells)] if any(cells) else []
            for one in claim.verdicts:
                if one.reading not in columns:
                    name = f"{claim.name}: {one.reading}" if claim.name and not one.rests.title else one.reading
                    alone = replace(claim, name=name[:1].upper() + name[1:], verdicts=[one])
                    rows.append((alone, [[one], *([] for _ in columns[1:])]))
        used = [place for place in range(len(columns)) if any(cells[place] for _, cells in rows)]
        tables.append(
            (basis, [columns[place] for place in used], [(claim, [cells[p] for p in used]) for claim, cells in rows])
        )
    return tables


def _verdict(
    row: Mapping[str, Cell],
    reading: str,
    rests: Rests,
    figures: Mapping[str, tuple[str, str]],
    tables: Sequence[tuple[str, ReportTable]],
) -> Verdict:
    where = str(row["where"])
    numbers = cited(where, "Figure")
    shown = [(name, " ".join(part for part in told if part)) for name, told in figures.items() if told[0] in numbers]
    if not shown:
        shown = [(name, " ".join(part for part in figures[name] if part)) for name in rests.figures if name in figures]
    asked = cited(where, "Table")
    listed = [(table.name, f"{table.paper} {table.title}") for _, table in tables if table.paper in asked]
    listed += [(t.name, t.title) for owner, t in tables if owner in rests.owners and not t.paper]
    return Verdict(row, reading, _close(row), rests, shown[:6], list(dict.fromkeys(listed))[:4])


def cited(where: str, what: str) -> set[str]:
    """Return the figures or tables that a place of a paper names, ranges of numbers spelt out.

    Arguments
    ---------
    where : as the statement gives it, "section 4, Figures 13 and 15" say.
    what : `Figure` or `Table`.
    """
    found: set[str] = set()
    for numbers in re.findall(rf"{what}s? ([0-9IVX]+(?:(?:, | and | to )[0-9IVX]+)*)", where):
        parts = re.split(r"(, | and | to )", numbers)
        found.add(f"{what} {parts[0]}")
        for place in range(1, len(parts), 2):
            last = parts[place + 1]
            if parts[place] == " to " and last.isdecimal():
                found |= {f"{what} {number}" for number in range(int(parts[place - 1]), int(last))}
            found.add(f"{what} {last}")
    return found


def _close(row: Mapping[str, Cell]) -> str:
    """Say why a verdict is a close call: its margin, or the interval of its share, is about where the word changes."""
    if row["verdict"] in ("not checkable", "undecided"):
        return ""
    low, high = row["robust_low"], row["robust_high"]
    if isinstance(low, float) and isinstance(high, float):
        enough = ENOUGH[0] / ENOUGH[1]
        for bound in (enough, 1.0 - enough):
            if low < bound < high:
                return f"the interval of its share, {100 * low:.0f} to {100 * high:.0f} %, spans {100 * bound:.0f} %"
        return ""
    margin, value, allowed = row["margin"], row["computed_value"], row["tolerance"]
    if isinstance(margin, float) and isinstance(allowed, float) and allowed:
        part = 100 * abs(margin / allowed)
        return f"its margin is {part:.2g} % of the tolerance" if part < 100 * CLOSE_OF_ALLOWED else ""
    if isinstance(margin, float) and isinstance(value, float) and value and abs(margin) < CLOSE * abs(value):
        part = 100 * abs(margin / value)
        return f"its margin is {part:.2g} % of the computed value" if part else "it lies on the limit"
    return ""


_LEADING = ("same", "at", "by", "in", "of", "off", "on", "within", "with")
"""Words that belong to what follows them."""


def _shared(names: Sequence[str]) -> int:
    """Return how many words identifiers share at their beginning, without those that belong to what follows."""
    parts = [name.split("_") for name in names]
    same = 0
    while all(len(part) > same for part in parts) and len({part[same] for part in parts}) == 1:
        same += 1
    while same and same < max(map(len, parts)) and parts[0][same - 1] in _LEADING:
        same -= 1
    return same


def _readings(names: Sequence[str]) -> list[str]:
    """Return how the readings of a claim are called: what their identifiers do not share."""
    if len(names) == 1:
        return [AS_STATED]
    same = _shared(names)
    return ["_".join(name.split("_")[same:]) or AS_STATED for name in names]


def _title(names: Sequence[str]) -> str:
    same = _shared(names) if len(names) > 1 else None
    return "_".join(names[0].split("_")[:same])


def called(text: str, names: Mapping[str, str]) -> str:
    """Return a text with the identifiers in it as people write them, the longest first."""
    for word in sorted(names, key=len, reverse=True):
        text = re.sub(rf"(?<![a-z0-9]){re.escape(word)}(?![a-z0-9])", lambda _, to=names[word]: to, text)  # type: ignore[misc]
    return text


def _written(name: str, names: Mapping[str, str]) -> str:
    """Return an identifier as people write it."""
    name = called(name, names)
    name = re.sub(r"(?<=\d)_(?=\d)", ".", name)
    name = re.sub(r"(?<![a-z0-9])cc_cv(?![a-z0-9])", "CC-CV", name)
    return re.sub(r"\bhz\b", "Hz", re.sub(r"\b(\d+)c\b", r"\1C", words(name)))


def count_bar(counts: Sequence[tuple[str, int]]) -> list[tuple[str, int, float]]:
    """Return word, number and share in percent of each word that occurs, for a bar."""
    total = sum(count for _, count in counts) or 1
    return [(word, count, 100.0 * count / total) for word, count in counts if word in WORDS]
