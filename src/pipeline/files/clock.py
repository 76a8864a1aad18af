"""The times of a person's table, row by row, and the time zones that they stand in."""

from __future__ import annotations

import datetime
import math
import zoneinfo
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files.cells import Table
from pipeline.files.time_columns import Read, found
from pipeline.record import OwnFile

Array = NDArray[np.float64]


class Clock(NamedTuple):
    """Times of a table's rows.

    Arguments
    ---------
    wall_s : as the clock shows them, since 1970-01-01 00:00 or since midnight [s]; NaN where a time cannot be read.
    offset_s : of local from universal time where a row says it, else NaN [s]; shape (n,) each.
    dated : whether they have dates.
    label : where in its interval a time stands, if the file says so.
    column : heading of the times, for messages; `allowed` : what they may be.
    told : what stands in a row.
    said : what was found.
    typical : whether the year is none that was: a typical one, or none is written.
    """

    wall_s: Array
    offset_s: Array
    dated: bool
    label: str | None
    column: str
    allowed: str
    told: Callable[[int], str]
    said: tuple[str, ...] = ()
    typical: bool = False


def clock_of(table: Table, own: OwnFile, date: datetime.date | None = None, key: str = "") -> Clock:
    """Return the times of a table.

    Arguments
    ---------
    table : the table.
    own : the record; its `columns`, `units` and `time_format`.
    date : the day that is asked for; its year stands in for one that the table does not have.
    key : key path of the record, for messages.

    Raises
    ------
    UserError : no column of times, or several; times that are partly dated or partly with an offset.
    """
    read = found(table, own, date, key)
    return _clock(table, read)


def _clock(table: Table, read: Read) -> Clock:
    readable = [one for one in read.moments if one is not None]
    if not readable and read.moments:
        raise table.refused(0, read.column, read.told(0), read.allowed)
    dated = not readable or readable[0].dated
    for row, one in enumerate(read.moments):
        if one is None:
            continue
        if one.dated != dated:
            allowed = "a column of times that all have a date, or none"
            raise table.refused(row, read.column, read.told(row), allowed)
        if (one.offset_s is None) != (readable[0].offset_s is None):
            allowed = "a column of times that all have an offset from universal time, or none"
            raise table.refused(row, read.column, read.told(row), allowed)
    wall = np.array([math.nan if one is None else one.wall_s for one in read.moments], dtype=np.float64)
    offset = np.array(
        [math.nan if one is None or one.offset_s is None else one.offset_s for one in read.moments], dtype=np.float64
    )
    label, said = read.label, read.said
    if label is None and any(one.at_24 for one in readable):
        label, said = "end", (*said, "24:00 occurs: times are the ends of their intervals")
    return Clock(wall, offset, dated, label, read.column, read.allowed, read.told, said, read.typical)


Zone = float | str
"""Local time less universal time [h], or the name of a zone with daylight saving."""
_UNIX = datetime.datetime(1970, 1, 1)


def universal_s(clock: Clock, zone: Zone | None) -> Array | None:
    """Return universal time since 1970 [s], shape (n,); none where nobody says how local time stands to it.

    Of the two hours that have one name when daylight saving ends, the first that stands in the file is the earlier.
    Times that no clock shows, when it begins, are NaN.

    Arguments
    ---------
    clock : dated times.
    zone : of local times that carry no offset.
    """
    if not np.isnan(clock.offset_s).all():
        return clock.wall_s - clock.offset_s
    if zone is None:
        return None
    return clock.wall_s - (3600.0 * zone if not isinstance(zone, str) else _offsets_s(clock.wall_s, zone))


def offset_s(zone: Zone, date: datetime.date) -> float:
    """Return local less universal time at noon of a date [s]."""
    if not isinstance(zone, str):
        return 3600.0 * zone
    noon = datetime.datetime.combine(date, datetime.time(12), zoneinfo.ZoneInfo(zone))
    found = noon.utcoffset()
    return 0.0 if found is None else found.total_seconds()


def local_s(clock: Clock, zone: Zone | None, date: datetime.date | None, path: Path, key: str) -> Array:
    """Return the local time of dated rows since 1970 [s], shape (n,), by the offset that holds at noon of the day.

    Raises
    ------
    UserError : universal times without a zone.
    """
    offsets = clock.offset_s[~np.isnan(clock.offset_s)]
    if zone is None:
        if len(offsets) and not offsets.any():
            first = _UNIX + datetime.timedelta(seconds=float(clock.wall_s[~np.isnan(clock.wall_s)][0]))
            raise UserError(
                f"{path}: its times are in universal time, from {first.isoformat()}+00:00 on; give utc_offset_h, local "
                f"time less universal time [h], 0 where they are the same: {key}utc_offset_h=1, say; or the zone, "
                f"{key}time_zone=Europe/Berlin"
            )
        return clock.wall_s
    if not len(offsets) and not isinstance(zone, str):
        return clock.wall_s
    universal = universal_s(clock, zone)
    assert universal is not None
    day = date or _date(universal + (offset_s(zone, datetime.date(2001, 1, 1)) if isinstance(zone, str) else 0.0))
    return universal + offset_s(zone, day)


def placed(clock: Clock, zone: str | None) -> Clock:
    """Return times that carry no offset with that of a named zone; others, and all without a zone, as they are."""
    if zone is None or not clock.dated or not np.isnan(clock.offset_s).all():
        return clock
    offset = _offsets_s(clock.wall_s, zone)
    gone = np.isnan(offset) & ~np.isnan(clock.wall_s)
    # What no clock of the zone shows cannot be read either: the hour that daylight saving leaves out.
    return clock._replace(offset_s=offset, wall_s=np.where(gone, np.nan, clock.wall_s))


def _date(seconds: Array) -> datetime.date:
    return (_UNIX + datetime.timedelta(seconds=float(seconds[~np.isnan(seconds)][0]))).date()


def _offsets_s(wall_s: Array, zone: str) -> Array:
    import pandas as pd

    stamps = pd.DatetimeIndex(np.where(np.isnan(wall_s), 0.0, wall_s).astype("datetime64[s]"))
    first = ~stamps.duplicated()
    found = stamps.tz_localize(zone, ambiguous=first, nonexistent="NaT")
    told = found.tz_convert("UTC").tz_localize(None)
    offset = (stamps - told).total_seconds().to_numpy(dtype=float)
    return np.where(np.isnan(wall_s), np.nan, offset)
