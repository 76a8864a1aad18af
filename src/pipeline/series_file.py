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

Array = NDArray[np.float64]
TIMES = ("time_s", "time")
"""Names of the column of time: seconds since midnight of the first day, or ISO 8601."""
_DAY_S = 86400.0


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


def read(path: Path, allowed: Mapping[str, Allowed], fewest: int = 2) -> dict[str, Array]:
    """Return `clock_s`, seconds since midnight of the first day, and the columns that are asked for, shape (n,) each.

    Arguments
    ---------
    path : a CSV file in UTF-8, or a Parquet file.
    allowed : name of each column, which ends in its unit -> what it may hold.
    fewest : rows that must be there.

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
    found = {"clock_s": _clock(path, rows)}
    for name, limits in allowed.items():
        if name in rows.columns:
            found[name] = np.array(list(_numbers(path, rows, name, limits)))
    return found


def _numbers(path: Path, rows: Rows, name: str, allowed: Allowed) -> Iterator[float]:
    for place, value in zip(rows.names, rows.columns[name], strict=True):
        number = _number(value)
        if number is None or not allowed.low <= number <= allowed.high:
            raise UserError(
                f"{path}: {place}, column {name}: {_shown(value)}; allowed is a number from {allowed.low:g} to "
                f"{allowed.high:g} {allowed.unit}"
            )
        yield number


def _clock(path: Path, rows: Rows) -> Array:
    given = [name for name in TIMES if name in rows.columns]
    if len(given) != 1:
        said = "both" if given else "neither"
        raise UserError(f"{path}: has {said} of the columns time_s [s] and time [ISO 8601]; one of them is needed")
    name = given[0]
    convert = _number if name == "time_s" else _moment
    wanted = "a number of seconds" if name == "time_s" else "a time as 2015-03-20T06:30:00"
    values: list[Any] = []
    for place, value in zip(rows.names, rows.columns[name], strict=True):
        moment = convert(value)
        if moment is None:
            raise UserError(f"{path}: {place}, column {name}: {_shown(value)}; allowed is {wanted}")
        values.append(moment)
    seconds = values if name == "time_s" else _since_midnight(path, rows, values)
    for row in range(1, len(seconds)):
        if seconds[row] <= seconds[row - 1]:
            raise UserError(
                f"{path}: {rows.names[row]}, column {name}: {_shown(rows.columns[name][row])}; allowed is a time after "
                f"that of the row before, {_shown(rows.columns[name][row - 1])}"
            )
    if seconds[0] < 0.0:
        raise UserError(f"{path}: {rows.names[0]}, column {name}: {seconds[0]:g}; allowed is 0 and above")
    return np.array(seconds, dtype=np.float64)


def _since_midnight(path: Path, rows: Rows, moments: Sequence[datetime.datetime]) -> list[float]:
    first = moments[0]
    for place, moment in zip(rows.names, moments, strict=True):
        if (moment.tzinfo is None) != (first.tzinfo is None):
            raise UserError(
                f"{path}: {place}, column time: {_shown(str(moment))}; allowed are times that all have an offset from "
                "universal time, or none"
            )
    midnight = first.replace(hour=0, minute=0, second=0, microsecond=0)
    return [(moment - midnight).total_seconds() for moment in moments]


def _number(value: Any) -> float | None:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) and not isinstance(value, bool) else None


def _moment(value: Any) -> datetime.datetime | None:
    if isinstance(value, datetime.datetime):
        return value
    try:
        return datetime.datetime.fromisoformat(value.strip())
    except (AttributeError, ValueError):
        return None


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
