"""The rows of one local day of a file, each from the start of its interval on."""

from __future__ import annotations

import datetime
from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files.cells import Table
from pipeline.files.clock import Clock, Zone, local_s, universal_s
from pipeline.files.moments import DAY_S
from pipeline.record import Label

Array = NDArray[np.float64]
# Clocks are put back by an hour at most.
PUT_BACK_S = 3601.0
_EPOCH = datetime.date(1970, 1, 1).toordinal()


class Rows(NamedTuple):
    """What is asked of a file.

    Arguments
    ---------
    table : the table; `key` : key path of its record with a dot behind, for messages.
    date : the day that is asked for, if one is.
    zone : local time, if it is known.
    label : where in its interval a row's time stands.
    fewest : rows that must be there.
    """

    table: Table
    key: str
    date: datetime.date | None
    zone: Zone | None
    label: Label
    fewest: int


class Day(NamedTuple):
    """Rows of a day.

    Arguments
    ---------
    rows : their places in the file, shape (n,).
    start_s : starts of their intervals since local midnight [s], shape (n,).
    universal_s : middles of the intervals in universal time since 1970 [s], if known.
    date : the local day; none for times of day.
    step_s : usual length of an interval in the file [s].
    said : what was found.
    """

    rows: NDArray[np.int64]
    start_s: Array
    universal_s: Array | None
    date: datetime.date | None
    step_s: float
    said: tuple[str, ...]


def day_of(clock: Clock, asked: Rows) -> Day:
    """Return the rows of the day that is asked for, and judge the times of no others.

    A file that has the day of another year, and of one only, is taken for a typical year.

    Raises
    ------
    UserError : no such day, several and none asked for, times that do not rise or cannot be read.
    """
    seconds = local_s(clock, asked.zone, asked.date, asked.table.path, asked.key) if clock.dated else clock.wall_s
    label = (clock.label or "start") if asked.label == "auto" else asked.label
    step_s = usual_step_s(seconds)
    share = {"start": 0.0, "middle": 0.5, "end": 1.0}[label]
    starts = seconds - share * step_s
    said = list(clock.said)
    if label != "start":
        said.append(f"times are the {label}s of intervals of {step_s:g} s")
    if not clock.dated:
        rows = np.arange(len(starts))
        _refuse_beyond(clock, asked, starts, label)
        _refuse_unordered(clock, asked, rows, starts)
        return Day(rows, starts, None, asked.date, step_s, tuple(said))
    rows, date = _dated(clock, asked, starts, said)
    _refuse_offsets(clock, asked, rows)
    _refuse_unordered(clock, asked, rows, starts)
    universal = universal_s(clock, asked.zone)
    middle = None if universal is None else universal[rows] + (0.5 - share) * step_s
    at_s = starts[rows] % DAY_S
    return Day(rows, at_s, middle, date, step_s, tuple(said))


def usual_step_s(seconds: Array) -> float:
    """Return the median distance of two times that follow each other [s]; a day where there is one alone."""
    steps = np.diff(seconds[~np.isnan(seconds)])
    rising = steps[steps > 0.0]
    return float(np.median(rising)) if len(rising) else DAY_S


def span(seconds: Array) -> str:
    """Return which days a file has, in words."""
    known = seconds[~np.isnan(seconds)]
    if not len(known):
        return "no row whose time can be read"
    first, last = (date_of(float(value)) for value in (known.min(), known.max()))
    return f"rows on {first}" if first == last else f"rows from {first} to {last}"


def date_of(seconds: float) -> datetime.date:
    """Return the date of local seconds since 1970."""
    return datetime.date.fromordinal(_EPOCH + int(seconds // DAY_S))


def midnight_s(date: datetime.date) -> float:
    """Return the local seconds since 1970 at which a date begins."""
    return DAY_S * (date.toordinal() - _EPOCH)


def _dated(clock: Clock, asked: Rows, starts: Array, said: list[str]) -> tuple[NDArray[np.int64], datetime.date]:
    days = np.floor(np.where(np.isnan(starts), np.inf, starts) / DAY_S)
    held = np.unique(days[np.isfinite(days)]).astype(int)
    date = asked.date
    if date is None:
        counts = [int(np.sum(days == day)) for day in held]
        if len(held) > 1 and sum(counts) - max(counts) <= 1:
            # The download of a day by the ends of intervals: its first row ends the day before.
            held = held[[int(np.argmax(counts))]]
        if len(held) > 1:
            raise UserError(
                f"{asked.table.path}: has {span(starts)}, and a weather is one day; choose it, "
                f"{asked.key}date={date_of(held[0] * DAY_S)}" + ", whatever the year" * clock.typical
            )
        date = date_of(float(held[0]) * DAY_S) if len(held) else datetime.date(1970, 1, 1)
    ordinal = date.toordinal() - _EPOCH
    rows = np.flatnonzero(days == ordinal)
    if not len(rows):
        rows = _of_typical_year(asked, clock, days, held, date, said)
    _refuse_unreadable(clock, asked, rows)
    if len(rows) < asked.fewest:
        raise UserError(
            f"{asked.table.path}: {len(rows)} rows on date {date}; it has {span(starts)}; allowed are "
            f"{asked.fewest} and more"
        )
    return rows, date


def _of_typical_year(
    asked: Rows, clock: Clock, days: Array, held: NDArray[np.int64], date: datetime.date, said: list[str]
) -> NDArray[np.int64]:
    """Return the rows of the same day of the year of a typical year; none where there is none.

    Raises
    ------
    UserError : no typical year, but that day of other years, which are named.
    """
    dates = (date_of(float(day) * DAY_S) for day in held)
    same = [one for one in dates if (one.month, one.day) == (date.month, date.day)]
    if same and (clock.typical or _is_typical(held)):
        found = max((np.flatnonzero(days == one.toordinal() - _EPOCH) for one in same), key=len)
        said.append(f"a typical year: {date:%d %B} stands there as {date_of(float(days[found[0]]) * DAY_S)}")
        return found
    if same:
        listed = ", ".join(map(str, same[:5]))
        raise UserError(
            f"{asked.table.path}: 0 rows on date {date}; it has that day of {listed}; choose it, "
            f"{asked.key}date={same[0]}"
        )
    return np.array([], dtype=np.int64)


def _is_typical(held: NDArray[np.int64]) -> bool:
    """Tell whether days are those of a year put together from months of several.

    A month has its days from one year, but for one or two at its ends, where universal and local time part.
    """
    years: dict[int, Counter[int]] = {}
    for day in held:
        one = date_of(float(day) * DAY_S)
        years.setdefault(one.month, Counter())[one.year] += 1
    most = [found.most_common(1)[0] for found in years.values()]
    whole = all(found.total() - count <= 2 for found, (_, count) in zip(years.values(), most, strict=True))
    return len(years) == 12 and whole and len({year for year, _ in most}) > 2


def _refuse_unreadable(clock: Clock, asked: Rows, rows: NDArray[np.int64]) -> None:
    """Refuse rows among those of the day, or right beside them, whose time cannot be read."""
    unreadable = np.isnan(clock.wall_s)
    if not unreadable.any():
        return
    near = np.zeros(len(unreadable), dtype=bool)
    near[rows] = True
    for row in np.flatnonzero(unreadable).tolist():
        before = near[:row][~unreadable[:row]][-1:]
        after = near[row + 1 :][~unreadable[row + 1 :]][:1]
        if before.any() or after.any():
            raise asked.table.refused(row, clock.column, clock.told(row), clock.allowed)


def _refuse_offsets(clock: Clock, asked: Rows, rows: NDArray[np.int64]) -> None:
    offsets = clock.offset_s[rows]
    if asked.zone is not None or np.isnan(offsets).any() or not len(offsets):
        return
    for row in rows[offsets != offsets[0]].tolist():
        first = datetime.timezone(datetime.timedelta(seconds=float(offsets[0])))
        shown = datetime.datetime(2001, 1, 1, tzinfo=first).strftime("%z")
        raise asked.table.refused(
            row,
            clock.column,
            clock.told(row),
            f"the offset of the first row, {shown}; or give utc_offset_h, for all rows, or a time_zone",
        )


def _refuse_beyond(clock: Clock, asked: Rows, starts: Array, label: str) -> None:
    for row in np.flatnonzero(np.isnan(starts) | (starts < 0.0) | (starts >= DAY_S)).tolist():
        hint = ""
        if label == "start" and clock.wall_s[row] == DAY_S:
            hint = f"; where a time is the end of its interval, {asked.key}label=end"
        elif label == "end" and starts[row] < 0.0:
            hint = "; times are the ends of their intervals, and none ends before it begins"
        raise asked.table.refused(row, clock.column, clock.told(row), clock.allowed + hint)


def _refuse_unordered(clock: Clock, asked: Rows, rows: NDArray[np.int64], starts: Array) -> None:
    wrong = np.flatnonzero(np.diff(starts[rows]) <= 0.0)
    if len(wrong):
        before, row = int(rows[wrong[0]]), int(rows[wrong[0] + 1])
        raise asked.table.refused(
            row,
            clock.column,
            clock.told(row),
            f"a time after that of the row before, {clock.told(before)}{_put_back(clock, asked, before, row)}",
        )


def _put_back(clock: Clock, asked: Rows, before: int, row: int) -> str:
    """Return what an hour that occurs twice looks like, for the end of a message; empty where like something else."""
    if asked.zone is None and not np.isnan(clock.offset_s[row]):
        return ""
    back_s = clock.wall_s[before] - clock.wall_s[row]
    if not clock.dated or not 0.0 <= back_s < PUT_BACK_S:
        return ""
    return f"; where clocks were put back, {asked.key}time_zone=Europe/Berlin, or the zone that it was"
