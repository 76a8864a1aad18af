"""A load that stands in a user's file, or in profiles by month, weekday and hour: what it draws on a day."""

from __future__ import annotations

import datetime
import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.load import Drawn
from pipeline.bus.records import WEEKDAYS, LoadProfile, MeasuredLoad, ProfileLoad
from pipeline.errors import UserError
from pipeline.files import headings, profiles, quantities
from pipeline.files.cells import Table
from pipeline.files.clock import Clock, clock_of, local_s, placed
from pipeline.files.days import midnight_s, span, usual_step_s
from pipeline.files.headings import values
from pipeline.files.moments import DAY_S
from pipeline.files.read import table
from pipeline.files.weather import date_of, weather_rows
from pipeline.own_files import digest
from pipeline.record import OwnFile
from pipeline.weather.records import Weather

Array = NDArray[np.float64]
_DAYS = (-1, 0, 1, 2)
"""Days about that of the weather for which a profile is drawn: the load at midnight and a charge into the next days."""
_QUANTITY = quantities.DRAWN
_SHARE = {"auto": 0.0, "start": 0.0, "middle": 0.5, "end": 1.0}
_DATED = "or give it in times of day, as 06:30 or in time_s, which hold every day"


def load_rows(load: LoadProfile, date: datetime.date | None, key: str = "load") -> Drawn | None:
    """Return what a load's file or profiles hold for a day, since its midnight; none where it has neither.

    Arguments
    ---------
    load : the record.
    date : the weather's local day, where it has one.
    key : key path of the record, for messages.

    Raises
    ------
    UserError : as for the weather; a load with dates that are not those of the weather; a profile without a day.
    """
    if isinstance(load, ProfileLoad):
        return _of_profiles(load, date, key)
    return _read(load, date, f"{key}.")[0] if isinstance(load, MeasuredLoad) else None


def told(load: LoadProfile, date: datetime.date | None, key: str = "load") -> tuple[str, ...]:
    """Return what was found in a load's file, in sentences; arguments and errors as for `load_rows`."""
    return _read(load, date, f"{key}.")[1] if isinstance(load, MeasuredLoad) else ()


def _read(load: MeasuredLoad, date: datetime.date | None, key: str) -> tuple[Drawn, tuple[str, ...]]:
    held = table(load)
    heading, said = _heading(held, load, key)
    if profiles.is_profile(held, load):
        found, more = profiles.drawn(held, load, heading, date, _DAYS, key)
        return found, (*held.said, *said, *more)
    clock = _clock(load.model_dump_json(), key, digest(Path(load.file)))
    _refuse_offset(held, load, clock)
    drawn, more = _of_times(held, load, clock, heading, date, key)
    return drawn, (*held.said, *said, *clock.said, *more)


@lru_cache(maxsize=8)
def _clock(record: str, key: str, content: str) -> Clock:
    load = MeasuredLoad.model_validate_json(record)
    return placed(clock_of(table(load), load, None, key), load.time_zone)


def _heading(held: Table, load: MeasuredLoad, key: str) -> tuple[str, tuple[str, ...]]:
    found = headings.match(held, load, quantities.LOAD, key)
    if "power_w" not in found.headings:
        asks = found.open or (
            f"no column 'power_w' [W]; {headings.spelled(key, 'power_w', 'HEADING')}, and "
            f"'{key}units={{power_w: kW}}', or Wh, kWh in each interval, where it is not W",
        )
        raise UserError(f"{held.path}: {'; and '.join(asks)}; its columns are {', '.join(held.columns)}")
    return found.headings["power_w"], found.said


def _of_times(
    held: Table, load: MeasuredLoad, clock: Clock, heading: str, date: datetime.date | None, key: str
) -> tuple[Drawn, tuple[str, ...]]:
    if not len(clock.wall_s):
        raise UserError(f"{held.path}: 0 rows; allowed are 1 and more")
    label = (clock.label or "start") if load.label == "auto" else load.label
    zone = load.utc_offset_h if load.utc_offset_h is not None else load.time_zone
    seconds = local_s(clock, zone, date, held.path, key) if clock.dated else clock.wall_s
    starts = seconds - _SHARE[label] * usual_step_s(seconds)
    if not clock.dated:
        return _every_day(held, load, clock, heading, starts, key)
    if date is None:
        raise UserError(f"{held.path}: has dates, {span(starts)}, and the weather has none; date the weather, {_DATED}")
    at_s = starts - midnight_s(date)
    known = np.where(np.isnan(at_s), np.inf, at_s)
    here = np.flatnonzero((known >= 0.0) & (known < DAY_S))
    if not len(here):
        raise UserError(f"{held.path}: no row on {date}, the day of the weather; it has {span(starts)}; {_DATED}")
    # What holds at midnight is the last row before it.
    rows = list(range(max(0, int(here[0]) - 1), int(here[-1]) + 1))
    _refuse_unordered(held, clock, rows, at_s)
    power, said = values(held, load, _QUANTITY, heading, rows, _lengths(at_s, rows), key)
    return Drawn(at_s[rows], power), said


def _every_day(
    held: Table, load: MeasuredLoad, clock: Clock, heading: str, starts: Array, key: str
) -> tuple[Drawn, tuple[str, ...]]:
    rows = list(range(len(starts)))
    for row in rows:
        if not 0.0 <= starts[row] < DAY_S:
            raise held.refused(row, clock.column, clock.told(row), clock.allowed)
    _refuse_unordered(held, clock, rows, starts)
    if starts[0] != 0.0:
        raise UserError(
            f"{held.path}: begins {starts[0]:g} s after midnight; a load of times of day is drawn every day and "
            "must begin at 0 s"
        )
    lengths = np.diff(starts, append=DAY_S)
    power, said = values(held, load, _QUANTITY, heading, rows, lengths, key)
    return Drawn(starts, power, repeats=True), said


def _lengths(at_s: Array, rows: Sequence[int]) -> Array:
    """Return the length of each row's interval, to the next row; of the last one in the file the usual length [s]."""
    following = np.append(at_s[1:], at_s[-1] + usual_step_s(at_s))
    lengths = np.asarray((following - at_s)[list(rows)], dtype=np.float64)
    # A row beside one whose time cannot be read, or at the turn of a file of several years, lasts as long as usual.
    return np.where(np.isnan(lengths) | (lengths <= 0.0), usual_step_s(at_s), lengths)


def _refuse_unordered(held: Table, clock: Clock, rows: Sequence[int], at_s: Array) -> None:
    for before, row in itertools.pairwise(rows):
        if np.isnan(at_s[row]):
            raise held.refused(row, clock.column, clock.told(row), clock.allowed)
        if at_s[row] <= at_s[before]:
            raise held.refused(
                row, clock.column, clock.told(row), f"a time after that of the row before, {clock.told(before)}"
            )


def _refuse_offset(held: Table, load: MeasuredLoad, clock: Clock) -> None:
    if load.utc_offset_h is not None and (not clock.dated or np.isnan(clock.offset_s).all()):
        raise UserError(
            f"{held.path}: its times carry no offset from universal time and are local; utc_offset_h is "
            f"{load.utc_offset_h:g}, allowed is null, or times as 2015-03-20T06:30:00Z"
        )


def _of_profiles(load: ProfileLoad, date: datetime.date | None, key: str) -> Drawn:
    if date is None:
        if len(load.profiles) > 1:
            raise UserError(f"{key}: goes by month and weekday, and the weather has no date; date the weather")
        hours = load.profiles[0].hours
        return Drawn(
            np.array([3600.0 * row.from_h for row in hours]), np.array([row.power_w for row in hours]), repeats=True
        )
    clock: list[float] = []
    power: list[float] = []
    for day in _DAYS:
        that = date + datetime.timedelta(days=day)
        weekday = WEEKDAYS[that.weekday()]
        fits = next(one for one in load.profiles if that.month in one.months and weekday in one.weekdays)
        clock += [DAY_S * day + 3600.0 * row.from_h for row in fits.hours]
        power += [row.power_w for row in fits.hours]
    return Drawn(np.array(clock), np.array(power))


def check_weather(path: str, weather: Weather) -> None:
    """Refuse weather whose file cannot be used.

    Arguments
    ---------
    path : key path of the weather.

    Raises
    ------
    UserError : with the key path, and below it what the file says.
    """
    with _named(path, weather):
        weather_rows(weather, path)


def check_load(path: str, load: LoadProfile, weather: Weather) -> None:
    """Refuse a load whose file cannot be used on the day of a weather; arguments and errors as for `check_weather`."""
    with _named(path, load):
        load_rows(load, date_of(weather), path)


@contextmanager
def _named(path: str, record: Weather | LoadProfile) -> Iterator[None]:
    where = f"{path}.file" if isinstance(record, OwnFile) else path
    if isinstance(record, OwnFile) and not record.file:
        raise UserError(f"{where}: no file is named; give a CSV, Parquet or Excel file, {path}.file=FILE")
    try:
        yield
    except UserError as error:
        raise UserError(f"{where}: {error}") from None
