"""Which columns of a table hold its times: one of them, a date and a time, or their parts."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files import moments, quantities
from pipeline.files.cells import Table, Torn, number, plain, shown
from pipeline.files.moments import DAY_S, DMY, MDY, YMD, Moment
from pipeline.record import OwnFile

Array = NDArray[np.float64]

SECONDS = "a time of day from 0 to below 86400 s; a file of more than a day has dates, in a column time [ISO 8601]"
WANTED = "a time as 2015-03-20T06:30:00, or a time of day as 06:30"
_WORDS = {
    **dict.fromkeys(
        ("time", "timestamp", "datetime", "dateandtime", "zeit", "zeitstempel", "localtime", "times"), "start"
    ),
    **dict.fromkeys(
        ("observationtime", "measuredat", "recordedat", "dateobs", "messdatum", "utctime", "timeutc"), "start"
    ),
    **dict.fromkeys(("periodstart", "intervalstart", "starttime", "start", "from"), "start"),
    **dict.fromkeys(("periodend", "intervalend", "endtime", "end"), "end"),
    **dict.fromkeys(("periodmidpoint", "intervalmiddle"), "middle"),
}
_SAYS_LABEL = ("period", "interval", "start", "end", "from")
_DATES = ("date", "datum", "day", "dateutc")
_PARTS = {
    "year": ("year", "yr", "yyyy", "jahr"),
    "month": ("month", "mo", "mon", "mm", "monat"),
    "day": ("day", "dy", "dom", "dayofmonth", "tag"),
    "hour": ("hour", "hr", "hh", "stunde", "hourofday"),
    "minute": ("minute", "min", "minutes"),
}
_EPOCH_S, _EPOCH_MS, _LATEST_MS = 1e8, 1e11, 1e13
_NO_YEAR = 2001


class Read(NamedTuple):
    """The times of a table row by row, none where one cannot be read; the other fields are those of a `Clock`."""

    moments: Sequence[Moment | None]
    column: str
    allowed: str
    told: Callable[[int], str]
    label: str | None = None
    said: tuple[str, ...] = ()
    typical: bool = False


def found(table: Table, own: OwnFile, date: datetime.date | None, key: str) -> Read:
    """Find the columns of time: named by the person, of a known name, or in parts."""
    columns = table.columns
    mapped = own.columns.get("time") or own.columns.get("time_s")
    if mapped is not None:
        partner = own.columns.get("date")
        return _date_and_time(table, own, partner, mapped) if partner else _column(table, own, mapped, key)
    exact = [name for name in ("time_s", "time") if name in columns]
    if len(exact) == 2:
        raise UserError(
            f"{table.path}: has both of the columns time_s [s] and time [ISO 8601]; one of them is needed, or say "
            f"which, {key}columns={{time: HEADING}}"
        )
    date_heading = _named(columns, _DATES)
    if exact and date_heading is None:
        return _column(table, own, exact[0], key)
    parts = _parts(columns)
    times = [name for name in columns if plain(name) in _WORDS]
    one_date = date_heading is not None and _holds_dates(columns[date_heading])
    if one_date and len(times) == 1 and not _holds_dates(columns[times[0]]):
        return _date_and_time(table, own, date_heading, times[0])
    if len(times) == 1:
        return _column(table, own, times[0], key)
    if len(times) > 1:
        starts = [name for name in times if plain(name).endswith("start")]
        if len(starts) == 1:
            return _column(table, own, starts[0], key)
        listed = ", ".join(map(repr, times))
        raise UserError(
            f"{table.path}: the columns {listed} may all be its times; say which, {key}columns={{time: {times[0]!r}}}"
        )
    if {"month", "day", "hour"} <= set(parts):
        return _of_parts(table, parts, date)
    if date_heading is not None and _holds_dates(columns[date_heading]):
        clock = next((name for name in columns if name != date_heading and _holds_clock(columns[name])), None)
        return _date_and_time(table, own, date_heading, clock) if clock else _column(table, own, date_heading, key)
    if "hour" in parts and "month" not in parts:
        return _of_hours(table, parts["hour"])
    dated = [name for name in columns if _holds_dates(columns[name]) and not isinstance(columns[name][0], int | float)]
    if len(dated) == 1:
        return _column(table, own, dated[0], key)
    raise UserError(
        f"{table.path}: has neither of the columns time_s [s] and time [ISO 8601]; one of them is needed, or say which "
        f"holds the times, {key}columns={{time: HEADING}}; its columns are {', '.join(columns)}"
    )


def _column(table: Table, own: OwnFile, name: str, key: str) -> Read:
    """Read one column of times: of day in seconds, in another unit, since 1970, or written."""
    if name not in table.columns:
        from pipeline.errors import best_matches

        raise UserError(
            f"{table.path}: no column {name!r}, which {key}columns.time names; {best_matches(name, table.columns)}"
        )
    cells = table.columns[name]
    told = _teller(cells)
    base, named = quantities.split(name)
    label = _WORDS.get(plain(name)) if any(word in plain(name) for word in _SAYS_LABEL) else None
    unit_named = own.units.get("time_s") or own.units.get("time")
    below = table.units.get(name, "").strip("[]()")
    if cells and quantities.unit(below, quantities.TIME) and number(cells[0], table.decimal) is not None:
        named = named or below
    if name == "time_s" or (named and quantities.unit(named, quantities.TIME)) or unit_named:
        wanted = unit_named or named or "s"
        factor = quantities.wanted(wanted, quantities.TIME, "time_s").factor
        values = [number(cell, table.decimal) for cell in cells]
        read = [None if value is None else Moment(value * factor, None, False) for value in values]
        return Read(read, name, SECONDS, told, label)
    numbers = [number(cell, table.decimal) for cell in cells[:50]]
    compact = any(moments.moment(cell) is not None for cell in cells[:50])
    if numbers and all(value is not None for value in numbers) and not compact:
        return _since_1970(table, name, key, told, label)
    order, said = _order(table, own, name, cells, key)
    read = [moments.moment(cell, order, own.time_format) for cell in cells]
    universal = (named or base).upper() in ("UTC", "GMT", "Z") or plain(name) in ("utctime", "timeutc")
    if universal and all(one is None or one.offset_s is None for one in read):
        read = [None if one is None else one._replace(offset_s=0.0) for one in read]
        said = (*said, f"heading {name!r}: universal time")
    return Read(read, name, _allowed(own), told, label, said)


def _since_1970(table: Table, name: str, key: str, told: Callable[[int], str], label: str | None) -> Read:
    values = [number(cell, table.decimal) for cell in table.columns[name]]
    some = [value for value in values if value is not None]
    if some and min(some) > _EPOCH_S and max(some) < _LATEST_MS:
        factor = 1e-3 if min(some) > _EPOCH_MS else 1.0
        said = f"column {name!r}: {'milliseconds' if factor < 1.0 else 'seconds'} since 1970 in universal time"
        read = [None if value is None else Moment(value * factor, 0.0) for value in values]
        return Read(read, name, WANTED, told, label, (said,))
    raise UserError(
        f"{table.path}: {table.named(0)}, column {name}: {told(0)}; allowed is {WANTED}; a number has a unit, "
        f"'{key}units={{time_s: s}}', min or h since midnight"
    )


def _order(table: Table, own: OwnFile, name: str, cells: Sequence[Any], key: str) -> tuple[str, tuple[str, ...]]:
    """Return the order of day and month of a column of dates; asked for where both are possible."""
    if own.time_format:
        return YMD, ()
    bracketed = (quantities.split(name)[1] or "").upper()
    if bracketed.startswith(("MM/DD", "MM-DD", "M/D")):
        return MDY, ()
    if bracketed.startswith(("DD/MM", "DD-MM", "DD.MM", "D/M")):
        return DMY, ()
    open_row = next((row for row, cell in enumerate(cells[:1000]) if moments.day_first_or_month_first(cell)), None)
    if open_row is None:
        return DMY, ()
    can = moments.orders(cells)
    if len(can) > 1:
        can = [order for order in can if _even(cells, order)] or can
    if len(can) != 1:
        raise UserError(
            f"{table.path}: {table.named(open_row)}, column {name}: {shown(cells[open_row])} may begin with the day or "
            f"the month; say which, '{key}time_format=\"%d/%m/%Y %H:%M\"' or '{key}time_format=\"%m/%d/%Y %H:%M\"'"
        )
    return can[0], (f"dates begin with the {'day' if can[0] == DMY else 'month'}",)


def _even(cells: Sequence[Any], order: str) -> bool:
    """Tell whether a column read in an order has days that rise one by one."""
    read = [moments.moment(cell, order) for cell in cells]
    days = {int(one.wall_s // DAY_S) for one in read if one is not None}
    return len(days) > 1 and max(days) - min(days) < 1.5 * len(days)


def _date_and_time(table: Table, own: OwnFile, date: str | None, time: str) -> Read:
    assert date is not None
    dates, times = table.columns[date], table.columns[time]

    def joined(row: int) -> Any:
        one, two = dates[row], times[row]
        if isinstance(one, Torn):
            return one
        if isinstance(one, datetime.datetime):
            one = one.date()
        if isinstance(two, datetime.time):
            two = two.isoformat()
        return f"{one} {two}"

    cells = [joined(row) for row in range(len(dates))]
    order, said = _order(table, own, date, cells, "")
    read = [moments.moment(cell, order, own.time_format) for cell in cells]
    return Read(read, f"{date} and {time}", _allowed(own), _teller(cells), None, said)


def _of_parts(table: Table, parts: Mapping[str, str], date: datetime.date | None) -> Read:
    """Read times from columns of year, month, day, hour, minute; hours from 1 to 24 are the ends of intervals."""
    columns = {part: [number(cell, table.decimal) for cell in table.columns[name]] for part, name in parts.items()}
    count = len(table.places)
    year = _NO_YEAR if date is None else date.year
    years = columns.get("year", [float(year)] * count)
    minutes = columns.get("minute", [0.0] * count)
    given = zip(years, columns["month"], columns["day"], columns["hour"], minutes, strict=True)
    read = [_part(values) for values in given]

    def told(row: int) -> str:
        torn = table.columns[parts["month"]][row]
        if isinstance(torn, Torn):
            return torn.told()
        return "value '" + " ".join(str(table.columns[name][row]) for name in parts.values()) + "'"

    names = " ".join(parts.values())
    said = () if "year" in parts else (f"no column of years: taken as of {year}",)
    return Read(read, names, "a date and an hour", told, None, said, "year" not in parts)


def _of_hours(table: Table, name: str) -> Read:
    """Read hours of a day; those from 1 to 24 are the ends of their intervals."""
    cells = table.columns[name]
    hours = [number(cell, table.decimal) for cell in cells]
    known = [hour for hour in hours if hour is not None]
    ends = bool(known) and min(known) > 0.0 and max(known) == 24.0
    read = [None if hour is None else Moment(3600.0 * hour, None, False, hour == 24.0) for hour in hours]
    said = (f"column {name!r}: hours of a day" + ", from 1 to 24, the ends of intervals" * ends,)
    return Read(
        read, name, "an hour from 0 to below 24, or from 1 to 24", _teller(cells), "end" if ends else None, said
    )


def _part(values: Sequence[float | None]) -> Moment | None:
    if any(value is None for value in values):
        return None
    year, month, day, hour, minute = (float(value) for value in values if value is not None)
    if hour > 24 and hour % 100 == 0:
        hour /= 100.0
    try:
        days = datetime.date(int(year), int(month), int(day)).toordinal() - datetime.date(1970, 1, 1).toordinal()
    except (ValueError, OverflowError):
        return None
    seconds = 3600.0 * hour + 60.0 * minute
    return Moment(DAY_S * days + seconds, None, True, hour == 24) if 0.0 <= seconds <= DAY_S else None


def _parts(columns: Mapping[str, Any]) -> dict[str, str]:
    found = {part: _named(columns, names) for part, names in _PARTS.items()}
    return {part: name for part, name in found.items() if name is not None}


def _named(columns: Mapping[str, Any], words: Sequence[str]) -> str | None:
    return next((name for word in words for name in columns if plain(name) == word), None)


def _holds_dates(cells: Sequence[Any]) -> bool:
    first = next((cell for cell in cells if cell not in (None, "")), None)
    read = [moments.moment(first, order) for order in (DMY, MDY)]
    return any(one is not None and one.dated for one in read)


def _holds_clock(cells: Sequence[Any]) -> bool:
    found = next((cell for cell in cells if cell not in (None, "")), None)
    read = moments.moment(found)
    return read is not None and not read.dated


def _allowed(own: OwnFile) -> str:
    return f"a time written as {own.time_format}" if own.time_format else WANTED


def _teller(cells: Sequence[Any]) -> Callable[[int], str]:
    def told(row: int) -> str:
        cell = cells[row]
        return cell.told() if isinstance(cell, Torn) else shown(cell)

    return told
