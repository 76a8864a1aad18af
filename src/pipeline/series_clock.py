"""The times of a person's own series: of a day, or with dates in local time."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeAlias

from pydantic import Field

from pipeline.errors import UserError

TIMES = ("time_s", "time")
"""Names of the column of time: seconds since midnight; or ISO 8601, a date and a time, or a time of day alone."""
DAY_S = 86400.0
FileOffset: TypeAlias = Annotated[
    float | None,
    Field(
        ge=-12,
        le=14,
        description="local time less universal time, for a file whose times carry an offset; without, they are local "
        "as they stand there [h]",
    ),
]
"""The key `utc_offset_h` of a record that names a file."""
_SECONDS = "a time of day from 0 to below 86400 s; a file of more than a day has dates, in a column time [ISO 8601]"
_WANTED = "a time as 2015-03-20T06:30:00, or a time of day as 06:30"
_MIDNIGHT = datetime.time()


class Clock(NamedTuple):
    """Times in seconds since midnight of the local day of the first one, and that day; none for times of day."""

    seconds: Sequence[float]
    date: datetime.date | None


def clock(
    path: Path,
    columns: Any,
    names: Sequence[str],
    number: Callable[[Any], float | None],
    shown: Callable[[Any], str],
    utc_offset_h: float | None = None,
) -> Clock:
    """Return the times of a file.

    Arguments
    ---------
    columns : name -> values as they stand there; `names` : what each row is called in a message.
    number, shown : read a value as a finite number; say it in a message.
    utc_offset_h : local time less universal time, for times that carry an offset [h].

    Raises
    ------
    UserError : with file, row, column, value and what is allowed.
    """
    given = [name for name in TIMES if name in columns]
    if len(given) != 1:
        said = "both" if given else "neither"
        raise UserError(f"{path}: has {said} of the columns time_s [s] and time [ISO 8601]; one of them is needed")
    name, values = given[0], columns[given[0]]

    def told(row: int, allowed: str) -> UserError:
        return UserError(f"{path}: {names[row]}, column {name}: {shown(values[row])}; allowed is {allowed}")

    found: list[Any] = []
    for row, value in enumerate(values):
        moment = number(value) if name == "time_s" else _moment(value)
        if moment is None:
            raise told(row, _SECONDS if name == "time_s" else _WANTED)
        if isinstance(moment, float) and not 0.0 <= moment < DAY_S:
            raise told(row, _SECONDS)
        if found and type(moment) is not type(found[0]):
            raise told(row, "a column of times that all have a date, or none")
        found.append(moment)
    made = _dated(path, found, told, utc_offset_h) if isinstance(found[0], datetime.datetime) else _of_day(found)
    if utc_offset_h is not None and (made.date is None or found[0].tzinfo is None):
        raise UserError(
            f"{path}: its times carry no offset from universal time and are local; utc_offset_h is {utc_offset_h:g}, "
            "allowed is null, or times as 2015-03-20T06:30:00Z"
        )
    for row in range(1, len(values)):
        if made.seconds[row] <= made.seconds[row - 1]:
            raise told(row, f"a time after that of the row before, {shown(values[row - 1])}")
    return made


def _of_day(times: Sequence[float | datetime.time]) -> Clock:
    return Clock([time if isinstance(time, float) else _since_midnight(time) for time in times], None)


def _since_midnight(time: datetime.time) -> float:
    return 3600.0 * time.hour + 60.0 * time.minute + time.second + 1e-6 * time.microsecond


def _dated(
    path: Path,
    moments: Sequence[datetime.datetime],
    told: Callable[[int, str], UserError],
    utc_offset_h: float | None,
) -> Clock:
    first = moments[0]
    for row, moment in enumerate(moments):
        if (moment.tzinfo is None) != (first.tzinfo is None):
            raise told(row, "a column of times that all have an offset from universal time, or none")
    offset = first.utcoffset()
    if utc_offset_h is not None and offset is not None:
        zone = datetime.timezone(datetime.timedelta(hours=utc_offset_h))
        moments = [moment.astimezone(zone) for moment in moments]
    elif offset is not None:
        if not offset:
            raise UserError(
                f"{path}: its times are in universal time, from {first.isoformat()} on; give utc_offset_h, local time "
                "less universal time [h], 0 where they are the same"
            )
        for row, moment in enumerate(moments):
            if moment.utcoffset() != offset:
                raise told(row, f"the offset of the first row, {first:%z}; or give utc_offset_h, for all rows")
    date = moments[0].date()
    midnight = datetime.datetime.combine(date, _MIDNIGHT, moments[0].tzinfo)
    return Clock([(moment - midnight).total_seconds() for moment in moments], date)


def _moment(value: Any) -> datetime.datetime | datetime.time | None:
    if isinstance(value, datetime.datetime | datetime.time):
        return value
    for read in (datetime.datetime.fromisoformat, datetime.time.fromisoformat):
        try:
            found = read(value.strip())
        except (AttributeError, ValueError):
            continue
        if isinstance(found, datetime.datetime) or (":" in value and found.tzinfo is None):
            return found
    return None
