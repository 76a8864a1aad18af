"""A person's own table of charging rates: read, checked, and refused in words that say what to mend."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.errors import UserError, best_matches
from pipeline.grnn.records import Data, data_of

COLUMNS = ("temperature_c", "gradient", "rate_c")


def read(path: Path, gradient_seconds: float) -> Data:
    """Return the data of a CSV or Parquet file with the columns temperature_c, gradient, rate_c.

    Arguments
    ---------
    gradient_seconds : seconds in the unit of its gradient.

    Raises
    ------
    UserError : no such file, another kind of file, a column missing or a value that is none.
    """
    if not path.is_file():
        raise UserError(f"{path}: no such file")
    readers = {".csv": _csv, ".parquet": _parquet}
    if path.suffix.lower() not in readers:
        raise UserError(f"{path}: ends in {path.suffix!r}; allowed are {', '.join(readers)}")
    columns = readers[path.suffix.lower()](path)
    for name in COLUMNS:
        if name not in columns:
            raise UserError(f"{path}: no column {name!r}; {best_matches(name, columns)}")
    try:
        temperature, gradient, rate = (_numbers(name, columns[name]) for name in COLUMNS)
        return data_of(temperature, gradient, rate, gradient_seconds)
    except ValueError as error:
        raise UserError(f"{path}: {error}") from None


def _numbers(name: str, values: list[Any]) -> list[float]:
    found = []
    for row, value in enumerate(values):
        try:
            found.append(float(value))
        except (TypeError, ValueError):
            raise ValueError(f"row {row + 1}: {name} is {value!r}; it must be a number") from None
    return found


def _csv(path: Path) -> dict[str, list[Any]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            rows = list(reader)
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: not a CSV file in UTF-8 ({error})") from None
    names = [name.strip() for name in reader.fieldnames or ()]
    return {name: [row[key] for row in rows] for name, key in zip(names, reader.fieldnames or (), strict=True)}


def _parquet(path: Path) -> dict[str, list[Any]]:
    try:
        found: dict[str, list[Any]] = pq.read_table(path).to_pydict()
    except (pa.ArrowInvalid, OSError) as error:
        raise UserError(f"{path}: not a readable Parquet file ({error})") from None
    return found
