"""A load's file by hour, and perhaps weekday and month, in place of times."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.load import Drawn
from pipeline.bus.records import MeasuredLoad
from pipeline.errors import UserError, best_matches
from pipeline.files import quantities
from pipeline.files.cells import Table, Torn, number, plain, shown
from pipeline.files.headings import values
from pipeline.files.moments import DAY_S
from pipeline.files.quantities import GRADIENT, RATE, TEMPERATURE, Quantity
from pipeline.files.read import table
from pipeline.record import OwnFile

Array = NDArray[np.float64]
_HOUR_S = 3600.0
_WORDS = {
    "month": ("month", "monat", "mo"),
    "weekday": ("weekday", "dayofweek", "wochentag", "dow", "daytype"),
    "hour": ("hour", "hr", "stunde", "hourofday", "fromh"),
}
_NAMES = {
    "month": ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"),
    "weekday": ("mon", "tue", "wed", "thu", "fri", "sat", "sun"),
}
_TIMES = ("time", "times", "timestamp", "date", "datetime", "day", "periodstart", "periodend")


def is_profile(table: Table, load: MeasuredLoad) -> bool:
    """Tell whether a load's table has hours and no times."""
    if load.columns.keys() & {"time", "time_s", "date"}:
        return False
    has_times = any(plain(name) in _TIMES for name in table.columns)
    return "hour" in _columns(table, load) and not has_times


def drawn(
    table: Table, load: MeasuredLoad, heading: str, date: datetime.date | None, days: Sequence[int], key: str
) -> tuple[Drawn, tuple[str, ...]]:
    """Return what a profile draws on the days about a date, since its midnight; without month and weekday every day.

    Arguments
    ---------
    table, load, heading : the table, its record, the heading of its power.
    date : the day of the weather, where it has one.
    days : days about it that are drawn, 0 being itself.
    key : key path of the record with a dot behind, for messages.

    Raises
    ------
    UserError : an hour that is none, an hour that a day does not have or has twice, weekdays without a date.
    """
    names = _columns(table, load)
    hours = [_hour(table, names["hour"], row) for row in range(len(table.places))]
    shift = 1.0 if hours and min(hours) == 1.0 and max(hours) == 24.0 else 0.0
    kinds: dict[str, list[int]] = {
        part: _numbers(table, part, names[part]) for part in ("month", "weekday") if part in names
    }
    kinds = {part: _from_zero(part, found) for part, found in kinds.items()}
    if not kinds:
        rows = list(range(len(hours)))
        clock, power, said = _day(table, load, heading, rows, hours, shift, key)
        return Drawn(clock, power, repeats=True), ("a profile of a day, the same every day", *said)
    if date is None:
        raise UserError(f"{table.path}: goes by {' and '.join(kinds)}, and the weather has no date; date the weather")
    more: tuple[str, ...] = ()
    clocks, powers = [], []
    for day in days:
        that = date + datetime.timedelta(days=day)
        rows = _of(kinds, that)
        if not rows and day != 0:
            continue
        if not rows:
            raise UserError(
                f"{table.path}: no row for {that:%A} in month {that.month}; allowed is one an hour for each"
            )
        clock, power, more = _day(table, load, heading, rows, hours, shift, key)
        clocks.append(clock + DAY_S * day)
        powers.append(power)
    said_kinds = f"a profile by {', '.join([*kinds, 'hour'])}"
    return Drawn(np.concatenate(clocks), np.concatenate(powers)), (said_kinds, *more)


def _of(kinds: Mapping[str, Sequence[int]], date: datetime.date) -> list[int]:
    wanted = {"month": date.month - 1, "weekday": date.weekday()}
    count = len(next(iter(kinds.values())))
    return [row for row in range(count) if all(found[row] == wanted[part] for part, found in kinds.items())]


def _day(
    table: Table, load: MeasuredLoad, heading: str, rows: list[int], hours: Sequence[float], shift: float, key: str
) -> tuple[Array, Array, tuple[str, ...]]:
    starts = np.array([_HOUR_S * (hours[row] - shift) for row in rows])
    order = np.argsort(starts, kind="stable")
    rows, starts = [rows[place] for place in order], starts[order]
    twice = np.flatnonzero(np.diff(starts) == 0.0)
    if len(twice):
        row = rows[int(twice[0]) + 1]
        raise UserError(f"{table.path}: {table.named(row)}: hour {hours[row]:g} of its day stands there twice")
    if starts[0] != 0.0:
        raise UserError(
            f"{table.path}: {table.named(rows[0])}: the first hour is {starts[0] / _HOUR_S:g}; allowed is 0, or 1"
        )
    power, said = values(table, load, quantities.DRAWN, heading, rows, np.diff(starts, append=DAY_S), key)
    return starts, power, said


def _hour(table: Table, heading: str, row: int) -> float:
    cell = table.columns[heading][row]
    text = str(cell).split(":")[0] if isinstance(cell, str) and ":" in cell else cell
    found = number(text, table.decimal)
    if found is None or not 0.0 <= found <= 24.0:
        told = (
            cell.told()
            if isinstance(cell, Torn)
            else f"{shown(cell)}; allowed is an hour from 0 to 23, or from 1 to 24"
        )
        raise UserError(f"{table.path}: {table.named(row)}, column {heading}: {told}")
    return found


def _numbers(table: Table, part: str, heading: str) -> list[int]:
    found = []
    for row, cell in enumerate(table.columns[heading]):
        short = str(cell).strip().lower()[:3]
        value = number(cell, table.decimal)
        if short in _NAMES[part]:
            found.append(_NAMES[part].index(short) + 1)
        elif value is not None and value == int(value) and 0 <= value <= len(_NAMES[part]):
            found.append(int(value))
        else:
            allowed = f"a number from 1 to {len(_NAMES[part])} or a name as {_NAMES[part][0]}"
            raise UserError(f"{table.path}: {table.named(row)}, column {heading}: {shown(cell)}; allowed is {allowed}")
    return found


def _from_zero(part: str, found: Sequence[int]) -> list[int]:
    """Return numbers of months or weekdays from 0 on, Monday being 0; those of a file with a 0 begin there already."""
    return list(found) if part == "weekday" and 0 in found else [one - 1 for one in found]


def _columns(table: Table, load: MeasuredLoad) -> dict[str, str]:
    found: dict[str, Any] = {}
    for part, words in _WORDS.items():
        named = load.columns.get(part) or next((name for name in table.columns if plain(name) in words), None)
        if named is not None and named in table.columns:
            found[part] = named
    return found


FEWEST, MOST = 2, 100_000
MOST_RATE_C, MOST_GRADIENT_K_S = 100.0, 1.0
"""Beyond what any cell is charged with, and beyond what a cell does short of thermal runaway."""


class Rates(NamedTuple):
    """Temperature [degC], gradient [K in the unit of time that was named], charging rate [C-rate], shape (m,) each."""

    temperature_c: Array
    gradient: Array
    rate_c: Array


def read(path: Path, gradient_seconds: float, key: str = "network.data.table") -> Rates:
    """Return a table with the columns temperature_c, gradient and rate_c; read and judged when a study is planned.

    Arguments
    ---------
    path : CSV, Parquet or Excel file, compressed or not.
    gradient_seconds : seconds in the unit of time of its gradient.
    key : key path that names the file, for messages.

    Raises
    ------
    UserError : with file, row, column, value and what is allowed.
    """
    if gradient_seconds <= 0.0:
        raise ValueError(f"gradient_seconds is {gradient_seconds:g}; it must be positive")
    own = OwnFile(file=str(path))
    held = table(own)
    columns = _quantities(gradient_seconds)
    for quantity in columns:
        if quantity.name not in held.columns:
            raise UserError(
                f"{path}: no column {quantity.name!r} [{quantity.unit}]; {best_matches(quantity.name, held.columns)}"
            )
    count = len(held.places)
    if not FEWEST <= count <= MOST:
        raise UserError(f"{path}: {count} points; allowed are {FEWEST} or more, and {MOST} at most")
    rows, lengths = range(count), np.ones(count)
    found = [values(held, own, one, one.name, rows, lengths, f"{key}.")[0] for one in columns]
    _refuse_twice(held, found[0], found[1])
    return Rates(*found)


def _quantities(gradient_seconds: float) -> Sequence[Quantity]:
    steepest = MOST_GRADIENT_K_S * gradient_seconds
    unit = {1.0: "K/s", 60.0: "K/min", 3600.0: "K/h"}.get(gradient_seconds, f"K in {gradient_seconds:g} s")
    nothing = frozenset[str]()
    return (
        Quantity("temperature_c", "", TEMPERATURE, "degC", -60.0, 120.0, nothing, "temperature of the cell"),
        Quantity("gradient", "", GRADIENT, unit, -steepest, steepest, nothing, "its gradient"),
        Quantity("rate_c", "", RATE, "C", 0.0, MOST_RATE_C, nothing, "charging rate"),
    )


def _refuse_twice(held: Table, temperature: Array, gradient: Array) -> None:
    seen: dict[tuple[float, float], int] = {}
    for row, point in enumerate(zip(temperature.tolist(), gradient.tolist(), strict=True)):
        if point in seen:
            raise UserError(
                f"{held.path}: {held.named(row)}: temperature_c {point[0]:g}, gradient {point[1]:g} stands there more "
                f"than once, first in {held.named(seen[point])}; each point may once"
            )
        seen[point] = row
