"""Rows of cells to a table: its headings, its data, what is no part of either, and the numbers in its cells."""

from __future__ import annotations

import datetime
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.errors import UserError
from pipeline.files import quantities
from pipeline.files.quantities import is_unit

_TIMELIKE = re.compile(r"\d{1,4}[-./:]\d{1,2}([-./:T ].*)?|\d{8}:\d{4}")
_FOOTERS = ("total", "totals", "sum", "mean", "average", "min", "max", "summe", "mittelwert")
_SAMPLE = 400


class Row(NamedTuple):
    """Cells of a row and its number in the file, from 1; a comment began with #."""

    number: int
    cells: Sequence[Any]
    comment: bool = False


def table_of(
    path: Path,
    rows: Sequence[Row],
    place: str,
    decimal: str = "auto",
    said: tuple[str, ...] = (),
    doubled: bool = False,
) -> Table:
    """Find the headings and the data among rows.

    The data are the rows of the commonest length most of whose cells are numbers or times. Their headings are the last
    row of words above them; a row of units may stand between. What is above the headings is the preamble.

    Arguments
    ---------
    rows : every row that is not empty, in order.
    place : what rows are called in messages.
    decimal : decimal sign, or "auto".
    doubled : whether a heading may stand there twice; the later ones are then numbered.

    Raises
    ------
    UserError : nothing there, no headings, a heading that stands there twice.
    """
    if not rows:
        raise UserError(f"{path}: empty; allowed is a line of column names, then rows")
    first = _first_of_data(rows)
    heading = _heading(path, rows, first)
    names = [str(cell).strip() if cell is not None else "" for cell in rows[heading].cells]
    while names and not names[-1]:
        names.pop()
    # Written by pandas: the index has no heading.
    names = [name or f"column {place}" * (place == 1) for place, name in enumerate(names, start=1)]
    data = [row for row in rows[heading + 1 :] if not row.comment]
    units: dict[str, str] = {}
    if data and _is_units(data[0], names):
        units = {name: str(cell).strip() for name, cell in zip(names, data[0].cells, strict=False) if cell}
        data = data[1:]
    data, footers = _without_footers(data, len(names))
    if doubled:
        names = _numbered(names)
    _refuse_twice(path, names, place, rows[heading].number)
    sample = [cell for row in data[:_SAMPLE] for cell in row.cells if isinstance(cell, str)]
    sign = decimal_of(sample) if decimal == "auto" else decimal
    found = [*said]
    if heading:
        found.append(f"headings in {place} {rows[heading].number}")
    if sign == ",":
        found.append("decimal comma")
    if footers:
        found.append(f"{footers} {place}{'s' * (footers > 1)} below the table left out")
    columns = _columns(names, data)
    return Table(
        path, columns, units, place, [row.number for row in data], _preamble(rows[:heading]), sign, tuple(found)
    )


def data_like(cells: Sequence[Any]) -> bool:
    """Tell whether cells are those of data: half of those that are filled are numbers or times, in two the first is."""
    filled = [cell for cell in cells if cell is not None and cell != ""]
    marks = [_is_value(cell) for cell in filled]
    if len(filled) == 2 and all(marks) and isinstance(filled[0], str) and _TIMELIKE.fullmatch(filled[0].strip()):
        return True  # a time and one value, the cells of other sensors empty
    if len(filled) <= 2:
        return bool(marks) and marks[0] and len(filled) == len([cell for cell in cells if cell is not None])
    return 2 * sum(marks) >= len(filled)


def _is_value(cell: Any) -> bool:
    if not isinstance(cell, str):
        return True
    text = cell.strip().strip('"')
    return number(text) is not None or number(text, ",") is not None or bool(_TIMELIKE.fullmatch(text))


def _first_of_data(rows: Sequence[Row]) -> int:
    """Return the place of the first row of data; the number of rows where there is none."""
    sample = rows if len(rows) <= 2 * _SAMPLE else [*rows[:_SAMPLE], *rows[-_SAMPLE:]]
    likely = [len(row.cells) for row in sample if not row.comment and data_like(row.cells)]
    lengths = Counter(likely)
    if not lengths:
        return len(rows)
    wanted = max(lengths, key=lambda length: (lengths[length], length))
    return next(
        place for place, row in enumerate(rows) if not row.comment and len(row.cells) == wanted and data_like(row.cells)
    )


def _heading(path: Path, rows: Sequence[Row], first: int) -> int:
    """Return the place of the headings: above the data, with units perhaps between."""
    width = len(rows[first].cells) if first < len(rows) else max(len(row.cells) for row in rows)
    above = [place for place in range(first) if not data_like(rows[place].cells)]
    fitting = [place for place in above if len(rows[place].cells) == width]
    if not fitting:
        # Another number of headings than of values: told row by row, with the remedy.
        fitting = [place for place in above if len(rows[place].cells) > 1 and place == first - 1]
    if not fitting and first == len(rows) and above:
        fitting = above[-1:]
    if not fitting:
        shown = ", ".join(str(cell) for cell in rows[0].cells[:6])
        raise UserError(
            f"{path}: line {rows[0].number}: no line of column names above the numbers; the first line is {shown!r}. "
            "Put one there, as time,ghi,ambient_c"
        )
    last = fitting[-1]
    if len(fitting) > 1 and fitting[-2] == last - 1 and _is_units(rows[last], rows[last - 1].cells):
        return last - 1
    return last


def _is_units(row: Row, names: Sequence[Any]) -> bool:
    """Tell whether a row below the headings holds units: each filled cell is one, or none of a number's."""
    filled = [str(cell) for cell in row.cells if cell is not None and str(cell).strip()]
    if len(row.cells) != len(names) or not filled or data_like(row.cells):
        return False
    return sum(is_unit(cell) for cell in filled) * 2 > len(filled)


def _without_footers(data: list[Row], width: int) -> tuple[list[Row], int]:
    """Leave out what stands below the last row of data: notes, and sums."""
    last = len(data)
    while last and not _belongs(data[last - 1], width):
        last -= 1
    return (data[:last], len(data) - last) if last else (data, 0)


def _belongs(row: Row, width: int) -> bool:
    begins = str(row.cells[0]).strip().lower().rstrip(":") if row.cells else ""
    if begins in _FOOTERS:
        return False
    return len(row.cells) == width or data_like(row.cells) or (len(row.cells) > 1 and width - len(row.cells) <= 1)


def _columns(names: Sequence[str], data: Sequence[Row]) -> dict[str, list[Any]]:
    wide = len(names)
    whole: list[Sequence[Any]] = []
    for row in data:
        cells = row.cells
        if len(cells) > wide and all(cell is None or cell == "" for cell in cells[wide:]):
            cells = cells[:wide]
        if len(cells) == wide:
            whole.append(cells)
        else:
            whole.append([Torn(len(cells), wide)] * wide)
    return {name: [cells[place] for cells in whole] for place, name in enumerate(names) if name}


def _numbered(names: Sequence[str]) -> list[str]:
    """Return headings with those that stood there before numbered from 2, as `Loop #2`."""
    seen: Counter[str] = Counter()
    found = []
    for name in names:
        seen[name] += 1
        found.append(f"{name} #{seen[name]}" if name and seen[name] > 1 else name)
    return found


def _refuse_twice(path: Path, names: Sequence[str], place: str, number: int) -> None:
    for name in names:
        if name and names.count(name) > 1:
            raise UserError(f"{path}: {place} {number}: column {name!r} stands there {names.count(name)} times")


def _preamble(rows: Sequence[Row]) -> Preamble:
    """Read pairs from what stands above: `key: value`, `key = value`, `key,value`, or a line of keys above values."""
    pairs: dict[str, str] = {}
    for place, row in enumerate(rows):
        cells = [str(cell).strip() for cell in row.cells if cell is not None]
        line = ",".join(cells)
        split = re.match(r"\s*([^:=]+?)\s*[:=]\s*(.+)", line)
        if len(cells) == 2 and cells[1]:
            pairs.setdefault(cells[0].rstrip(":="), cells[1])
        elif split:
            pairs.setdefault(split[1], split[2])
        below = rows[place + 1].cells if place + 1 < len(rows) else ()
        if len(cells) > 2 and len(below) == len(row.cells):
            for key, value in zip(row.cells, below, strict=True):
                pairs.setdefault(str(key).strip(), str(value).strip())
    lines = tuple(",".join("" if cell is None else str(cell) for cell in row.cells) for row in rows)
    return Preamble(lines, pairs)


_ONE_EACH = "one a column"


class Preamble(NamedTuple):
    """What stands above a table: its lines, and the pairs of key and value among them."""

    lines: tuple[str, ...] = ()
    pairs: Mapping[str, str] = {}


class Table(NamedTuple):
    """Columns as they stand in a file.

    Arguments
    ---------
    path : the file.
    columns : heading -> cells, all of one length; in a row of another length than the headings each is a `Torn`.
    units : heading -> unit, where a row of units stands below the headings.
    place : what rows are called, "line" or "row"; `places` : number of each.
    preamble : what stands above.
    decimal : decimal sign of its text.
    said : what was found, in sentences.
    """

    path: Path
    columns: Mapping[str, Sequence[Any]]
    units: Mapping[str, str]
    place: str
    places: Sequence[int]
    preamble: Preamble = Preamble()
    decimal: str = "."
    said: tuple[str, ...] = ()

    def named(self, row: int) -> str:
        """Return what a row is called in a message."""
        return f"{self.place} {self.places[row]}"

    def refused(self, row: int, column: str, told: str, allowed: str) -> UserError:
        """Return the refusal of a cell, or of a row that has another length than the headings.

        Arguments
        ---------
        row, column : its place and heading.
        told : what stands there, as `pipeline.files.cells.shown` or `Torn.told` says it.
        allowed : what may stand there.
        """
        where = f"{self.path}: {self.named(row)}"
        return UserError(
            f"{where}: {told}" if _ONE_EACH in told else f"{where}, column {column}: {told}; allowed is {allowed}"
        )


class Torn(NamedTuple):
    """Stands in every cell of a row whose number of cells is not that of the headings."""

    cells: int
    wanted: int

    def told(self) -> str:
        """Return what is wrong with the row, for a message."""
        hint = ""
        if self.cells >= 2 * self.wanted - 1:
            hint = (
                "; decimal commas between commas cannot be told apart: save it with semicolons or tabs between columns"
            )
        return f"{self.cells} values; allowed are {self.wanted}, {_ONE_EACH}{hint}"


class Stamp(NamedTuple):
    """A time that a file holds as a time: seconds since 1970-01-01 00:00, of universal or of local time."""

    seconds: float
    universal: bool

    def __repr__(self) -> str:
        """Return it as messages tell it."""
        try:
            told = (datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=self.seconds)).isoformat()
        except OverflowError:
            return f"{self.seconds:g} s after 1970"
        return f"{told}Z" if self.universal else told


_LONGEST = 100
_POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d+", re.ASCII)


def number(value: Any, decimal: str = ".") -> float | None:
    """Return a value as a finite number; none where it is not one: a word, a truth value, digits of other scripts.

    Arguments
    ---------
    value : as it stands in the file.
    decimal : the file's decimal sign, for text; with a comma, points between groups of three digits are left out.
    """
    if isinstance(value, str):
        text = value.strip()
        if decimal == ",":
            text = text.replace(".", "").replace(",", ".") if _GROUPED.fullmatch(text) else text.replace(",", ".")
        if not _POINT.fullmatch(text):
            return None
        found = float(text)
    elif value is None or isinstance(value, bool) or not hasattr(value, "__float__"):
        return None
    else:
        found = float(value)
    return found if math.isfinite(found) else None


def decimal_of(cells: Iterable[str]) -> str:
    """Return the decimal sign that a text file's cells are written with: a comma where only commas are."""
    commas = points = 0
    for cell in cells:
        text = cell.strip()
        commas += bool(_COMMA.fullmatch(text) or _GROUPED.fullmatch(text))
        points += "." in text and bool(_POINT.fullmatch(text))
    return "," if commas and not points else "."


def shown(value: Any) -> str:
    """Return a value as a message says it."""
    if value is None or value == "":
        return "empty"
    text = repr(value) if isinstance(value, str) else str(value)
    return f"value {text if len(text) <= _LONGEST else text[:_LONGEST] + '...'}"


_HEIGHT = re.compile(r"(?:at|@)?\s*\d+(?:\.\d+)?\s*(?:m|ft|feet)\b|_?\d+m$", re.IGNORECASE)


def plain(heading: str) -> str:
    """Return a heading as a word: without its unit, capitals, spaces and signs."""
    return re.sub(r"[^a-z0-9]", "", _folded(quantities.split(heading)[0]))


def bare(heading: str) -> str:
    """Return a heading as a word, without the height above ground at which something was measured too."""
    return re.sub(r"[^a-z0-9]", "", _folded(_HEIGHT.sub("", quantities.split(heading)[0])))


def _folded(text: str) -> str:
    return text.lower().replace("ä", "ae").replace("ö", "oe").replace("ü", "ue").replace("é", "e")
