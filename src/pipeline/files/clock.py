"""The times of a person's table, row by row."""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.file_record import OwnFile
from pipeline.files.table import Table
from pipeline.files.time_columns import Read, found

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
