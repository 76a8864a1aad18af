"""A person's own series over time as CSV or Parquet: read, checked row by row, refused in words that help."""

from __future__ import annotations

import csv
import datetime
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from pipeline.errors import UserError, best_matches
from pipeline.series_clock import clock

Array = NDArray[np.float64]


class Allowed(NamedTuple):
    """What a column may hold."""

    low: float
    high: float
    unit: str
    needed: bool = True


class Rows(NamedTuple):
    """A file's columns as they stand there, and what each row is called in a message."""

    columns: Mapping[str, Sequence[Any]]
    names: Sequence[str]


class Series(NamedTuple):
    """Columns over time: seconds since midnight of the first local day, and its date; none for times of day."""

    clock_s: Array
    columns: Mapping[str, Array]
    date: datetime.date | None


def read(path: Path, allowed: Mapping[str, Allowed], fewest: int = 2, utc_offset_h: float | None = None) -> Series:
    """Return times and the columns that are asked for, shape (n,) each.

    Arguments
    ---------
    path : a CSV file in UTF-8, or a Parquet file.
    allowed : name of each column, which ends in its unit -> what it may hold.
    fewest : rows that must be there.
    utc_offset_h : local time less universal time, for times that carry an offset [h].

    Raises
    ------
    UserError : with file, row, column, value and what is allowed.
    """
    if not path.is_file():
        raise UserError(f"{path}: no such file")
    readers = {".csv": _csv, ".parquet": _parquet}
    if path.suffix.lower() not in readers:
        raise UserError(f"{path}: ends in {path.suffix!r}; allowed are {', '.join(readers)}")
    rows = readers[path.suffix.lower()](path)
    for name, limits in allowed.items():
        if name not in rows.columns and limits.needed:
            raise UserError(f"{path}: no column {name!r} [{limits.unit}]; {best_matches(name, rows.columns)}")
    if len(rows.names) < fewest:
        raise UserError(f"{path}: {len(rows.names)} rows; allowed are {fewest} and more")
    times = clock(path, rows.columns, rows.names, _number, _shown, utc_offset_h)
    columns = {
        name: np.array(list(_numbers(path, rows, name, limits)))
        for name, limits in allowed.items()
        if name in rows.columns
    }
    return Series(np.array(times.seconds, dtype=np.float64), columns, times.date)


def _numbers(path: Path, rows: Rows, name: str, allowed: Allowed) -> Iterator[float]:
    for place, value in zip(rows.names, rows.columns[name], strict=True):
        number = _number(value)
        if number is None or not allowed.low <= number <= allowed.high:
            raise UserError(
                f"{path}: {place}, column {name}: {_shown(value)}; allowed is a number from {allowed.low:g} to "
                f"{allowed.high:g} {allowed.unit}"
            )
        yield number


def _number(value: Any) -> float | None:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) and not isinstance(value, bool) else None


def _shown(value: Any) -> str:
    return (
        "empty" if value is None or value == "" else f"value {value!r}" if isinstance(value, str) else f"value {value}"
    )


def _csv(path: Path) -> Rows:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(reader.line_num, line) for reader in [csv.reader(file)] for line in reader if any(line)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: not a CSV file in UTF-8 ({error})") from None
    if not lines:
        raise UserError(f"{path}: empty; allowed is a line of column names, then rows")
    header = [name.strip() for name in lines[0][1]]
    for name in header:
        if header.count(name) > 1:
            raise UserError(f"{path}: line {lines[0][0]}: column {name!r} stands there {header.count(name)} times")
    for number, line in lines[1:]:
        if len(line) != len(header):
            raise UserError(f"{path}: line {number}: {len(line)} values; allowed are {len(header)}, one a column")
    columns = {name: [line[place].strip() for _, line in lines[1:]] for place, name in enumerate(header)}
    return Rows(columns, [f"line {number}" for number, _ in lines[1:]])


def _parquet(path: Path) -> Rows:
    try:
        columns: dict[str, list[Any]] = pq.read_table(path).to_pydict()
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError, OSError) as error:
        raise UserError(f"{path}: not a readable Parquet file ({error})") from None
    count = len(next(iter(columns.values()), []))
    return Rows(columns, [f"row {row + 1}" for row in range(count)])
