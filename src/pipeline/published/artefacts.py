"""Reads the numbers that predicates name, and their units, out of the artefacts' tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from pipeline.errors import UserError, best_matches
from pipeline.kernel.artefacts import Inputs
from pipeline.kernel.experiment import kind_of
from pipeline.kernel.tables import TableFile
from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value, text
from pipeline.published.reference import PRINTED, REFERENCE, is_named, read_csv
from pipeline.record import Record

Columns = dict[str, np.ndarray[Any, Any]]


class Unanswerable(Exception):
    """A value that this run does not hold; the message says what is missing.

    Arguments
    ---------
    why : what is missing; where an operand is given, what is wrong with it.
    operand : what has no number; its words stand before the reason.
    """

    def __init__(self, why: str, operand: Operand | None = None) -> None:
        super().__init__(why if operand is None else f"{text(operand)} {why}")
        self.why = why
        self.operand = operand


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

    def unit(self, value: Value) -> str | None:
        """Return the unit of a value as its table declares it; none where it declares none."""

    def held(self, operand: float | Record) -> float | None:
        """Return the number of an operand that need not be looked up; none where it must."""


class Lookup:
    """The artefacts of a run, and the papers' own tables as `reference/<name>`.

    Arguments
    ---------
    inputs : the artefacts.
    printed : the folder of the papers' own tables.
    """

    def __init__(self, inputs: Inputs, printed: Path = REFERENCE) -> None:
        self._inputs = inputs
        self._printed = printed

    def table(self, artefact: str, name: str) -> Columns:
        """Return a table as column -> array; raise `Unanswerable` where this run has no such input."""
        if kind_of(artefact) == PRINTED:
            file = self._printed / f"{name}.csv"
            if not file.is_file():
                raise Unanswerable(f"{artefact} is not part of this run")
            return read_csv(file)
        if artefact not in self._inputs:
            raise Unanswerable(f"{artefact} is not part of this run")
        if not self._inputs.holds(artefact, name):
            raise Unanswerable(f"{artefact}.{name} is not part of this run")
        return self._inputs.table(artefact, name)

    def declared(self, value: Value) -> TableFile | None:
        """Return how the table of a value is declared; none for a paper's own."""
        return self._inputs.declared(value.artefact, value.table)

    def unit(self, value: Value) -> str | None:
        """Return the unit of a value as its table declares it; none for a paper's own, and for what is not there."""
        declared = self.declared(value)
        if declared is None or not self._inputs.holds(value.artefact, value.table):
            return None
        columns = {column.name: column.unit for column in declared.table.columns}
        if not is_named(declared.table) and not columns.get(value.quantity, "").startswith("see"):
            return columns.get(value.quantity)
        if "unit" not in columns:
            return None
        data = self._inputs.table(value.artefact, value.table)
        rows = data["quantity"] == value.quantity if is_named(declared.table) else _chosen(value, data)
        found = {str(unit) for unit in data["unit"][rows]}
        return found.pop() or "1" if len(found) == 1 else None

    def held(self, operand: float | Record) -> float | None:
        """Return nothing: every operand is looked up."""
        return None

    def number(self, value: Value) -> float:
        """Return one number; an empty time among named numbers is infinite: what it waits for did not happen."""
        found = self.column(value)
        if len(found) != 1:
            raise Unanswerable(f"{value} has {len(found)} rows, not one")
        number = float(found[0])
        if np.isnan(number):
            declared = self.declared(value)
            if declared is not None and is_named(declared.table) and self.unit(value) == "s":
                return float("inf")
            raise Unanswerable(f"{value} is empty")
        return number

    def column(self, value: Value) -> np.ndarray[Any, Any]:
        """Return a column over the rows chosen; named numbers count as columns of one row."""
        data = self.table(value.artefact, value.table)
        declared = self.declared(value)
        if declared is not None and is_named(declared.table):
            found = data["value"][data["quantity"] == value.quantity]
            if not len(found):
                raise Unanswerable(f"{value} is not part of this run")
            return np.asarray(found, float)
        return np.asarray(_column(value, value.quantity, data)[_chosen(value, data)])

    def series(self, value: Value) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Return the time in s and a column over the rows chosen."""
        declared = self.declared(value)
        data = self.table(value.artefact, value.table)
        if declared is None or declared.time is None:
            raise UserError(f"{value}: table {value.table} has no column of time")
        rows = _chosen(value, data)
        if not rows.any():
            raise Unanswerable(f"{value} has no rows")
        return data[declared.time][rows], _column(value, value.quantity, data)[rows]


class Impossible(Unanswerable):
    """A point of the estimated parameters that no battery can have."""


class Sample(Lookup):
    """The artefacts, with some of the numbers that statements read as one point of the estimated parameters has them.

    Arguments
    ---------
    nominal : the artefacts.
    numbers : operand in one line -> its number; NaN where it has none, nothing where no battery can be as the point.
    of : what the points are.
    """

    def __init__(self, nominal: Lookup, numbers: Mapping[str, float | None], of: str) -> None:
        self._nominal = nominal
        self.numbers = numbers
        self.of = of

    def table(self, artefact: str, name: str) -> Columns:
        """Return a table that does not vary over the points."""
        return self._nominal.table(artefact, name)

    def declared(self, value: Value) -> TableFile | None:
        """Return how the table of a value is declared."""
        return self._nominal.declared(value)

    def unit(self, value: Value) -> str | None:
        """Return the unit of a value."""
        return self._nominal.unit(value)

    def held(self, operand: float | Record) -> float | None:
        """Return the number of an operand in this point; an empty time is infinite, as in `Lookup.number`."""
        name = text(operand)
        if name not in self.numbers:
            return None
        found = self.numbers[name]
        if found is None:
            raise Impossible(f"{name}: no battery can be so")
        if not np.isnan(found):
            return found
        declared = self.declared(operand) if isinstance(operand, Value) else None
        if isinstance(operand, Value) and declared and is_named(declared.table) and self.unit(operand) == "s":
            return float("inf")
        raise Unanswerable(f"{name} is empty")


def number(operand: Operand, reader: Reader) -> float:
    """Return the number an operand stands for.

    Raises
    ------
    Unanswerable : an input is not part of the run, or a value is empty or not a number.
    """
    result = _number(operand, reader)
    if math.isnan(result):
        raise Unanswerable("is not a number", operand)
    return result


def _number(operand: Operand, reader: Reader) -> float:
    held = reader.held(operand)
    if held is not None:
        return held
    match operand:
        case Value():
            return reader.number(operand)
        case Difference(difference=(left, right)):
            return number(left, reader) - number(right, reader)
        case Ratio(ratio=(left, right)):
            divisor = number(right, reader)
            return number(left, reader) / divisor if divisor else math.nan
        case Product(product=factors):
            return math.prod(number(factor, reader) for factor in factors)
        case Total(total=column):
            found = reader.column(column)
            return float(np.sum(found)) if len(found) else math.nan
        case AtTime(at_time=moment):
            time = number(moment.time, reader)
            if math.isinf(time):
                raise Unanswerable("was not reached by the charge", moment.time)
            return float(np.interp(time, *reader.series(moment.value)))
        case _:
            return float(operand)


def _chosen(value: Value, data: Columns) -> np.ndarray[Any, Any]:
    rows = np.ones(len(next(iter(data.values()))), dtype=bool)
    for name, wanted in value.where.items():
        column = _column(value, name, data)
        rows &= np.isclose(column, wanted, rtol=1e-9, atol=1e-9) if isinstance(wanted, float) else column == wanted
    return rows


def _column(value: Value, name: str, data: Columns) -> np.ndarray[Any, Any]:
    if name not in data:
        raise UserError(f"{value}: nothing is called {name!r}; {best_matches(name, list(data))}")
    return data[name]
