"""Times as people write them."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from pipeline.files.cells import Stamp
from pipeline.weather.records import YEARS

DAY_S = 86400.0
_EPOCH = datetime.date(1970, 1, 1).toordinal()
_CLOCK = r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:[.,]\d+)?))?\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
_ZONE = r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2}|[+-]\d{2})?"
_DATED = re.compile(
    r"(?P<one>\d{1,4})(?P<sign>[-./])(?P<two>\d{1,2})(?P=sign)(?P<three>\d{1,4})(?:(?:[T ,;:]|\s+)\s*"
    + _CLOCK
    + _ZONE
    + ")?",
    re.ASCII,
)
_OF_DAY = re.compile(_CLOCK, re.ASCII)
_COMPACT = re.compile(
    r"(?P<one>\d{4})(?P<two>\d{2})(?P<three>\d{2})(?:[T:_ ]?(?P<hour>\d{2}):?(?P<minute>\d{2})?(?P<second>\d{2})?)?"
    + _ZONE,
    re.ASCII,
)
YMD, DMY, MDY = "ymd", "dmy", "mdy"


class Moment(NamedTuple):
    """Seconds since 1970-01-01 00:00 as the clock shows them, or since midnight; offset from universal time."""

    wall_s: float
    offset_s: float | None = None
    dated: bool = True
    at_24: bool = False


_EARLIEST_S, _END_S = (DAY_S * (datetime.date(year, 1, 1).toordinal() - _EPOCH) for year in (YEARS[0], YEARS[-1] + 1))


def moment(value: Any, order: str = YMD, time_format: str | None = None) -> Moment | None:
    """Return a time, none where it is none or its year none of `YEARS`.

    Arguments
    ---------
    value : as it stands in the file: text, a date and time, a time of day.
    order : order of day, month and year where the year does not stand first.
    time_format : of strptime, where the person gives one.
    """
    found = _moment(value, order, time_format)
    within = found is None or not found.dated or _EARLIEST_S <= found.wall_s < _END_S
    return found if within else None


def _moment(value: Any, order: str, time_format: str | None) -> Moment | None:
    if isinstance(value, Stamp):
        return Moment(value.seconds, 0.0 if value.universal else None)
    if isinstance(value, datetime.datetime):
        offset = value.utcoffset()
        return Moment(_wall(value), None if offset is None else offset.total_seconds())
    if isinstance(value, datetime.date):
        return Moment(DAY_S * (value.toordinal() - _EPOCH))
    if isinstance(value, datetime.time):
        return Moment(_clock_s(value.hour, value.minute, value.second + 1e-6 * value.microsecond), dated=False)
    if not isinstance(value, str):
        return None
    text = value.strip()
    return _formatted(text, time_format) if time_format else _written(text, order)


def orders(values: Sequence[Any]) -> list[str]:
    """Return the orders of day and month that all dates of a column can have: one where a day beyond 12 tells."""
    can = [DMY, MDY]
    for value in values:
        found = _DATED.fullmatch(value.strip()) if isinstance(value, str) else None
        if found is None or len(found["one"]) == 4:
            continue
        if found["sign"] == ".":
            return [DMY]
        if int(found["one"]) > 12 and DMY in can:
            can = [DMY]
        elif int(found["two"]) > 12 and MDY in can:
            can = [MDY]
        if len(can) == 1:
            return can
    return can


def day_first_or_month_first(value: Any) -> bool:
    """Tell whether a value's order of day and month is open: neither the year first nor points between."""
    found = _DATED.fullmatch(value.strip()) if isinstance(value, str) else None
    return found is not None and len(found["one"]) < 4 and found["sign"] != "."


def _written(text: str, order: str) -> Moment | None:
    of_day = _OF_DAY.fullmatch(text)
    if of_day:
        seconds = _seconds(of_day)
        return None if seconds is None else Moment(seconds, None, False, seconds == DAY_S)
    found = _DATED.fullmatch(text)
    if found:
        parts = int(found["one"]), int(found["two"]), int(found["three"])
        if len(found["one"]) == 4:
            year, month, day = parts
        elif len(found["three"]) == 4:
            year, (day, month) = parts[2], parts[:2] if order != MDY else parts[1::-1]
        else:
            return None
        return _at(year, month, day, found)
    found = _COMPACT.fullmatch(text)
    if found:
        return _at(int(found["one"]), int(found["two"]), int(found["three"]), found)
    return None


def _at(year: int, month: int, day: int, found: re.Match[str]) -> Moment | None:
    seconds = _seconds(found) if found["hour"] is not None else 0.0
    if seconds is None or year not in YEARS:
        return None
    days = _days(year, month, day)
    if days is None:
        return None
    return Moment(DAY_S * days + seconds, _offset_s(found["zone"]), True, seconds == DAY_S)


@lru_cache(maxsize=4096)
def _days(year: int, month: int, day: int) -> int | None:
    """Return the days of a date since 1970; none where there is no such date."""
    try:
        return datetime.date(year, month, day).toordinal() - _EPOCH
    except ValueError:
        return None


def _seconds(found: re.Match[str]) -> float | None:
    """Return the time of day of a match; 24:00 is the end of the day."""
    groups = found.groupdict()
    hour, minute = int(groups["hour"]), int(groups["minute"] or 0)
    second = float((groups["second"] or "0").replace(",", "."))
    half = (groups.get("half") or "").lower().replace(".", "")
    if half:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + 12 * (half == "pm")
    if hour == 24 and minute == 0 and second == 0.0:
        return DAY_S
    return _clock_s(hour, minute, second) if hour < 24 and minute < 60 and second < 60.0 else None


def _offset_s(zone: str | None) -> float | None:
    if not zone:
        return None
    if zone in ("Z", "UTC", "GMT"):
        return 0.0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return (-1.0 if zone[0] == "-" else 1.0) * (3600.0 * int(digits[:2]) + 60.0 * int(digits[2:]))


def _formatted(text: str, time_format: str) -> Moment | None:
    try:
        found = datetime.datetime.strptime(text, time_format)
    except ValueError:
        return None
    offset = found.utcoffset()
    dated = any(mark in time_format for mark in ("%d", "%j", "%x", "%c", "%s"))
    wall = _wall(found) if dated else _clock_s(found.hour, found.minute, found.second + 1e-6 * found.microsecond)
    return Moment(wall, None if offset is None else offset.total_seconds(), dated)


def _wall(value: datetime.datetime) -> float:
    days = value.toordinal() - _EPOCH
    return DAY_S * days + _clock_s(value.hour, value.minute, value.second + 1e-6 * value.microsecond)


def _clock_s(hour: int, minute: int, second: float) -> float:
    return 3600.0 * hour + 60.0 * minute + second
