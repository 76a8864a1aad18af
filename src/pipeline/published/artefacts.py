"""Reads the numbers that predicates name out of the artefacts' tables."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from pipeline import tables
from pipeline.errors import UserError, best_matches
from pipeline.published.names import NAMED, kind, source
from pipeline.published.operands import Value

Columns = dict[str, np.ndarray[Any, Any]]
Key = tuple[str, str, str]


class Unanswerable(Exception):
    """A value that this run does not hold; the message says what is missing."""


class Reader(Protocol):
    """What predicates read from."""

    def number(self, value: Value) -> float:
        """Return one number, or raise `Unanswerable`."""

    def column(self, value: Value) -> np.ndarray[Any, Any]:
        """Return a column over the rows chosen."""

    def series(self, value: Value) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return the time in s and a column over the rows chosen."""

    def table(self, artefact: str, name: str) -> Columns:
        """Return a whole table."""


class Lookup:
    """Artefacts by input name; tables are read once, when they are first asked for.

    Arguments
    ---------
    folders : input name -> folder with its tables; a `reference/...` input is a CSV file or the folder that holds it.
    """

    def __init__(self, folders: Mapping[str, Path]) -> None:
        self._folders = dict(folders)
        self._read: dict[tuple[str, str], Columns] = {}

    def table(self, artefact: str, name: str) -> Columns:
        """Return a table as column -> array; raise `Unanswerable` where this run has no such input."""
        if artefact not in self._folders:
            raise Unanswerable(f"{artefact} is not part of this run")
        if (artefact, name) not in self._read:
            folder = self._folders[artefact]
            if kind(artefact) == "reference":
                self._read[artefact, name] = _read_csv(folder if folder.is_file() else folder / f"{name}.csv")
            else:
                found = source(kind(artefact), name)
                if found is None or not (folder / found.file).is_file():
                    raise Unanswerable(f"{artefact}.{name} is not part of this run")
                self._read[artefact, name] = tables.read(found.table, folder / found.file)
        return self._read[artefact, name]

    def number(self, value: Value) -> float:
        """Return one number; an empty time to an SOC is infinite: the charge ended before it got there."""
        found = self.column(value)
        if len(found) != 1:
            raise Unanswerable(f"{value} has {len(found)} rows, not one")
        number = float(found[0])
        if np.isnan(number):
            if value.table == "summary" and value.quantity.startswith("time_to_soc_"):
                return float("inf")
            raise Unanswerable(f"{value} is empty")
        return number

    def column(self, value: Value) -> np.ndarray[Any, Any]:
        """Return a column over the rows chosen; named numbers count as columns of one row."""
        data = self.table(value.artefact, value.table)
        if value.table in NAMED:
            found = data["value"][data["quantity"] == value.quantity]
            if not len(found) and value.table != "summary":
                raise Unanswerable(f"{value} is not part of this run")
            if not len(found):
                raise _unknown(value, value.quantity, data["quantity"].tolist())
            return np.asarray(found)
        return np.asarray(_column(value, value.quantity, data)[_chosen(value, data)])

    def series(self, value: Value) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return the time in s and a column over the rows chosen."""
        declared = source(kind(value.artefact), value.table)
        if declared is None or declared.time is None:
            raise UserError(f"{value}: table {value.table} has no column of time")
        data = self.table(value.artefact, value.table)
        rows = _chosen(value, data)
        if not rows.any():
            raise Unanswerable(f"{value} has no rows")
        return data[declared.time][rows], _column(value, value.quantity, data)[rows]

    def samples(self) -> list[dict[Key, float]]:
        """Return what each sample of the ensemble found: (comparison, mode, quantity) -> number; none without one."""
        if "ensemble" not in self._folders:
            return []
        data = self.table("ensemble", "ensemble")
        found: dict[int, dict[Key, float]] = {}
        columns = (data[name].tolist() for name in ("sample", "comparison", "mode", "quantity", "value"))
        for sample, comparison, mode, quantity, value in zip(*columns, strict=True):
            found.setdefault(sample, {})[comparison, mode, quantity] = value
        return [found[sample] for sample in sorted(found)]


class Sample(Lookup):
    """The artefacts with the charges' summaries of one sample of the ensemble in place of their own."""

    def __init__(self, nominal: Lookup, found: Mapping[Key, float]) -> None:
        self._nominal = nominal
        self._found = found

    def holds_key(self, key: Key) -> bool:
        """Tell whether the sample has a row for a number, empty or not."""
        return key in self._found

    def table(self, artefact: str, name: str) -> Columns:
        """Return a table that does not vary over the ensemble."""
        return self._nominal.table(artefact, name)

    def column(self, value: Value) -> np.ndarray[Any, Any]:
        """Return a column; the summary's numbers come from the sample."""
        if value.table != "summary":
            return super().column(value)
        key = ensemble_key(value)
        if key not in self._found:
            raise Unanswerable(f"{value} is not in the ensemble")
        return np.array([self._found[key]])


def ensemble_key(value: Value) -> Key:
    """Return the key of a summary's number in the ensemble."""
    _, comparison, mode = value.artefact.split("/")
    return comparison, mode, value.quantity


def _chosen(value: Value, data: Columns) -> np.ndarray[Any, Any]:
    rows = np.ones(len(next(iter(data.values()))), dtype=bool)
    for name, wanted in value.where.items():
        column = _column(value, name, data)
        rows &= np.isclose(column, wanted, rtol=1e-9, atol=1e-9) if isinstance(wanted, float) else column == wanted
    return rows


def _column(value: Value, name: str, data: Columns) -> np.ndarray[Any, Any]:
    if name not in data:
        raise _unknown(value, name, list(data))
    return data[name]


def _unknown(value: Value, name: str, known: list[str]) -> UserError:
    return UserError(f"{value}: nothing is called {name!r}; {best_matches(name, known)}")


def _read_csv(path: Path) -> Columns:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: _numbers([row[name] for row in rows]) for name in (rows[0] if rows else ())}


def _numbers(cells: list[str]) -> np.ndarray[Any, Any]:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)
