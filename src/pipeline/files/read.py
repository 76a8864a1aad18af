"""One reader for every file of a person: what it is, and its table."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.errors import UserError, best_matches
from pipeline.files.cells import Row, Stamp, Table, data_like, table_of
from pipeline.files.content import Content, is_excel, load, text_of
from pipeline.own_files import digest
from pipeline.record import OwnFile

_DELIMITERS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "spaces"}
_SAMPLE = 400


def read(content: Content, decimal: str = "auto", doubled: bool = False) -> Table:
    """Return the table of a text file.

    Arguments
    ---------
    content : the file.
    decimal : decimal sign, or "auto".
    doubled : whether headings may stand there twice.

    Raises
    ------
    UserError : no text, nothing in it, no headings.
    """
    text, said = text_of(content)
    if text.lstrip()[:1] in ("{", "["):
        raise UserError(f"{content.path}: is JSON, of which only PVGIS's is read; save it as CSV")
    lines = text.splitlines()
    delimiter = delimiter_of(lines)
    rows = _text_table_rows(content, lines, delimiter)
    if delimiter != ",":
        said = (*said, f"columns divided by {_DELIMITERS[delimiter]}")
    return table_of(content.path, rows, "line", decimal, (*content.said, *said), doubled)


def delimiter_of(lines: Sequence[str]) -> str:
    """Return the sign that divides most lines into one same number of cells of data.

    Between signs that do so alike the order decides, in which a comma is late: it may be the decimal sign.
    """
    sample = [line for line in (*lines[:_SAMPLE], *lines[-_SAMPLE:]) if line.strip() and not line.startswith("#")]
    best, most = ",", (0, 0)
    for delimiter in _DELIMITERS:
        split = [_split(line, delimiter) for line in sample]
        widths = Counter(len(cells) for cells in split if len(cells) > 1 and data_like(cells))
        width, count = widths.most_common(1)[0] if widths else (0, 0)
        if delimiter == " " and most[0]:
            continue
        if (count, width > 1) > most:
            best, most = delimiter, (count, width > 1)
    if not most[0]:
        first = next((line for line in sample), "")
        best = max(_DELIMITERS, key=lambda sign: (first.count(sign) > 0, sign != " ", first.count(sign)))
    return best


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return [line]


def _text_table_rows(content: Content, lines: Sequence[str], delimiter: str) -> list[Row]:
    """Return the rows that are not empty; the last comment above the data may hold the headings."""
    found: list[Row] = []
    if delimiter == " ":
        parsed = ((place + 1, line.split()) for place, line in enumerate(lines))
    else:
        reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
        parsed = ((reader.line_num, cells) for cells in reader)
    try:
        for number, cells in parsed:
            stripped = [cell.strip() for cell in cells]
            comment = bool(stripped) and stripped[0].startswith("#")
            if comment:
                stripped[0] = stripped[0].lstrip("# ")
            if any(stripped):
                found.append(Row(number, stripped, comment))
    except csv.Error as error:
        raise UserError(f"{content.path}: not a CSV file that can be read ({error})") from None
    return found


_MOST_ROWS = 2_000_000


def parquet(content: Content) -> Table:
    """Return the table of a Parquet file; times keep whether they are universal.

    Raises
    ------
    UserError : no Parquet file that can be read, or columns of a kind that no table has.
    """
    try:
        found = pq.read_table(io.BytesIO(content.data))
        columns = {str(name): _cells(found.column(name)) for name in found.column_names}
    except (pa.ArrowException, OSError, ValueError, OverflowError) as error:
        raise UserError(f"{content.path}: not a readable Parquet file ({error})") from None
    rows = range(1, found.num_rows + 1)
    return Table(content.path, columns, {}, "row", rows, said=content.said)


def _cells(column: pa.ChunkedArray) -> Sequence[Any]:
    kind = column.type
    if pa.types.is_timestamp(kind):
        micro = column.cast(pa.timestamp("us", tz=kind.tz), safe=False).cast(pa.int64()).to_pylist()
        universal = kind.tz is not None
        return [None if value is None else Stamp(value * 1e-6, universal) for value in micro]
    if pa.types.is_date(kind):
        return [None if value is None else value.isoformat() for value in column.to_pylist()]
    if pa.types.is_floating(kind):
        values = column.to_numpy()
        return [
            None if empty else value for value, empty in zip(values.tolist(), np.isnan(values).tolist(), strict=True)
        ]
    cells: list[Any] = column.to_pylist()
    return cells


def excel(content: Content, sheet: str | None, decimal: str = "auto", doubled: bool = False) -> Table:
    """Return the table of a sheet of an Excel workbook: the named one, or the first that holds data.

    Raises
    ------
    UserError : openpyxl is not installed, no workbook that can be read, no such sheet, no table in any.
    """
    try:
        import openpyxl
    except ModuleNotFoundError:
        raise UserError(
            f"{content.path}: is an Excel file, which openpyxl reads, and that is not installed; "
            "`pip install openpyxl`, or save the sheet as CSV"
        ) from None
    try:
        book = openpyxl.load_workbook(io.BytesIO(content.data), read_only=True, data_only=True)
        names = list(book.sheetnames)
        if sheet is not None and sheet not in names:
            raise UserError(f"{content.path}: no sheet {sheet!r}; {best_matches(sheet, names)}")
        held = {name: _rows(book[name]) for name in ([sheet] if sheet is not None else names)}
    except UserError:
        raise
    except Exception as error:  # what openpyxl raises on damage is of every kind
        raise UserError(f"{content.path}: not a readable Excel file ({error})") from None
    chosen = next((name for name, rows in held.items() if sum(data_like(row.cells) for row in rows) > 1), None)
    if chosen is None:
        chosen = next(iter(held))
    others = f" of {len(names)}" if len(names) > 1 else ""
    said = (*content.said, f"sheet {chosen!r}{others}")
    return table_of(content.path, held[chosen], "row", decimal, said, doubled)


def _rows(sheet: Any) -> list[Row]:
    """Return the rows of a sheet that are not empty, without the empty columns at their end."""
    found: list[Row] = []
    for number, cells in enumerate(sheet.iter_rows(values_only=True), start=1):
        if number > _MOST_ROWS:
            break
        filled = list(cells)
        while filled and filled[-1] is None:
            filled.pop()
        if filled:
            found.append(Row(number, filled))
    width = max((len(row.cells) for row in found), default=0)
    # A sheet has one width: what ends early ends in empty cells, unless it stands above the table.
    wide = [row for row in found if len(row.cells) == width]
    start = wide[0].number if wide else 0
    return [
        row._replace(cells=[*row.cells, *[None] * (width - len(row.cells))]) if row.number >= start else row
        for row in found
    ]


_PARQUET = b"PAR1"


def table(own: OwnFile) -> Table:
    """Return the table of a person's file; read once until its content changes.

    Arguments
    ---------
    own : the file, and what is said of how it is written.

    Raises
    ------
    UserError : a file that holds no table; the message says what was found and what is allowed.
    """
    path = Path(own.file)
    return _table(path, own.sheet, own.decimal, digest(path))


@lru_cache(maxsize=8)
def _table(path: Path, sheet: str | None, decimal: str, content: str) -> Table:
    return of_content(load(path, sheet), sheet, decimal)


def of_content(content: Content, sheet: str | None = None, decimal: str = "auto", doubled: bool = False) -> Table:
    """Return the table of bytes: Parquet and Excel by what they begin with, else text; errors as for `table`."""
    if content.data.startswith(_PARQUET) or content.name.lower().endswith((".parquet", ".pq")):
        return parquet(content)
    if is_excel(content.data):
        return excel(content, sheet, decimal, doubled)
    return read(content, decimal, doubled)
