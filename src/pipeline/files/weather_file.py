"""A weather's file, whatever its format: its table, its times, its header, and what is asked for in one message."""

from __future__ import annotations

import datetime
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeline.errors import UserError
from pipeline.files import headings, pvlib_files
from pipeline.files.cells import Preamble, Table, number
from pipeline.files.clock import Clock, Zone, clock_of, placed
from pipeline.files.content import Content, is_excel, load, text_of
from pipeline.files.days import date_of, span
from pipeline.files.headings import Found
from pipeline.files.moments import DAY_S
from pipeline.files.pvlib_files import BY_NAME, Header, Known, taken_for
from pipeline.files.read import of_content
from pipeline.own_files import digest
from pipeline.weather.records import LIGHT, MeasuredWeather
from pipeline.weather.transposition import enough

_CHOSEN = 120
_OPEN_METEO = {"utc_offset_seconds", "timezone_abbreviation"}
_KEYS = {
    "latitude_deg": r"\blat(itude)?\b",
    "longitude_deg": r"\blon(g|gitude)?\b|\blng\b",
    "altitude_m": r"\b(alt(itude)?|elev(ation)?)\b",
    "utc_offset_h": r"\b(time ?zone|tz|utc.?offset(.?h(ours)?)?|timezone)\b",
}


class WeatherFile(NamedTuple):
    """A weather's file.

    Arguments
    ---------
    table, clock, header : what stands there, the times of its rows, where it was measured.
    own : the record, with what the format writes where nothing was measured.
    said : what was found, in sentences.
    """

    table: Table
    clock: Clock
    header: Header
    own: MeasuredWeather
    said: tuple[str, ...]


def opened(weather: MeasuredWeather, key: str) -> WeatherFile:
    """Return a weather's file; read once until its content or its record changes.

    Arguments
    ---------
    weather : the record.
    key : its key path with a dot behind, for messages.

    Raises
    ------
    UserError : a file that cannot be read as what it is said to be, or was taken for.
    """
    return _opened(weather.model_dump_json(), key, digest(Path(weather.file)))


@lru_cache(maxsize=8)
def _opened(record: str, key: str, content: str) -> WeatherFile:
    weather = MeasuredWeather.model_validate_json(record)
    date = None if weather.date is None else datetime.date.fromisoformat(weather.date)
    loaded = load(Path(weather.file), weather.sheet)
    known = _known(loaded, weather)
    if known is not None:
        return _by_pvlib(loaded, weather, known)
    table = of_content(loaded, weather.sheet, weather.decimal)
    clock = placed(clock_of(table, weather, date, key), weather.time_zone)
    if clock.label is None and set(table.preamble.pairs) >= _OPEN_METEO:
        # https://open-meteo.com/en/docs: radiation is the mean of the preceding hour.
        clock = clock._replace(label="end", said=(*clock.said, "taken for Open-Meteo"))
    return WeatherFile(table, clock, header_of(table.preamble), weather, table.said)


def _known(content: Content, weather: MeasuredWeather) -> Known | None:
    """Return the format that is named, or that the first lines are of; none for a table."""
    if weather.format not in ("auto", "csv"):
        return BY_NAME[weather.format]
    if weather.format == "csv" or is_excel(content.data) or content.data.startswith(b"PAR1"):
        return None
    text, _ = text_of(content._replace(data=content.data[: 1 << 18])) if b"\0" not in content.data[:512] else ("", ())
    return taken_for(text.splitlines()[:_CHOSEN])


def _by_pvlib(content: Content, weather: MeasuredWeather, known: Known) -> WeatherFile:
    if weather.time_format or weather.decimal != "auto":
        key = "time_format" if weather.time_format else "decimal"
        raise UserError(f"{content.path}: is {known.title}, which says itself how it is written; leave {key} out")
    found = pvlib_files.read(content, known, weather.format != "auto")
    said = f"taken for {known.title}, read by pvlib" if weather.format == "auto" else f"{known.title}, read by pvlib"
    own = weather.model_copy(update={"missing": (*weather.missing, "nan")})
    return WeatherFile(
        found.table, placed(found.clock, weather.time_zone), found.header, own, (said, *found.table.said)
    )


def zone_of(file: WeatherFile) -> Zone | None:
    """Return the zone of local time: that of the place, of the record, of the file's times, of its header."""
    own = file.own
    if own.place is not None:
        return own.place.utc_offset_h
    if own.utc_offset_h is not None:
        return own.utc_offset_h
    return own.time_zone if own.time_zone is not None else file.header.utc_offset_h


def transposed(own: MeasuredWeather, light: set[str]) -> bool:
    """Tell whether light on the horizontal is used: there is no other, or the panel's plane is given."""
    return "irradiance_w_m2" not in light or (own.surface is not None and enough(light))


def header_of(preamble: Preamble) -> Header:
    """Return where a table was measured, from the pairs above it; NASA POWER has several in a line."""
    pairs = dict(preamble.pairs)
    for line in preamble.lines:
        for name in ("latitude", "longitude"):
            found = re.search(name + r"\s+(-?\d+\.?\d*)", line, re.IGNORECASE)
            if found:
                pairs.setdefault(name, found[1])
    values: dict[str, float] = {}
    for field, pattern in _KEYS.items():
        for name, text in pairs.items():
            plain = name.replace("_", " ")
            if not re.search(pattern, plain, re.IGNORECASE) or field in values:
                continue
            value = number(re.sub(r"[^\d.+-].*$", "", text.strip()))
            if value is not None:
                values[field] = value / 3600.0 if "second" in plain.lower() else value
    bounds = {"latitude_deg": 90.0, "longitude_deg": 180.0, "altitude_m": 9000.0, "utc_offset_h": 14.0}
    return Header(**{field: value for field, value in values.items() if abs(value) <= bounds[field]})


_MOST_LISTED = 20


def ask(file: WeatherFile, found: Found, key: str) -> None:
    """Ask in one message for all that the file does not say.

    Raises
    ------
    UserError : light, air, the panel's plane, the place or the local time that is missing.
    """
    own, names = file.own, set(found.headings)
    asks = list(found.open)
    light = names & set(LIGHT)
    if not light or ("irradiance_w_m2" not in light and not enough(light)):
        if not any("light" in one or "irradiance" in one for one in asks):
            asks.append(_no_light(file, light, key))
    elif transposed(own, light):
        if own.surface is None:
            asks.append(
                f"its light is on the horizontal ({', '.join(sorted(light))}); say how the panel stands, "
                f"'{key}surface={{tilt_deg: 30, azimuth_deg: 180, albedo: 0.2}}', tilt_deg 0 for one that lies flat"
            )
        asks += _no_place(file, key)
    asks += _no_offset(file, bool(light) and transposed(own, light), key)
    if "ambient_c" not in names and own.ambient_c is None and not any("of the air" in one for one in asks):
        asks.append(
            f"no column 'ambient_c' [degC], the temperature of the air; {_spelled(key, 'ambient_c')}, or a constant "
            f"one, {key}ambient_c=20"
        )
    asks = [one for one in asks if "may all be the speed" not in one or own.wind_m_s is None]
    if asks:
        asks += _no_date(file, key)
        columns = f"; its columns are {_listed(file)}" if any("olumn" in one for one in asks) else ""
        raise UserError(f"{file.table.path}: " + "; and ".join(asks) + columns)


def _no_date(file: WeatherFile, key: str) -> list[str]:
    """Ask for the day too, where a file of many is asked about anything."""
    seconds = file.clock.wall_s[~np.isnan(file.clock.wall_s)]
    if file.own.date is not None or not file.clock.dated or not len(seconds) or np.ptp(seconds) <= DAY_S:
        return []
    middle = date_of(float(np.median(seconds)))
    if file.clock.typical:
        return [f"it is a typical year, of which one day is taken, as {key}date={middle}, whatever the year"]
    return [f"it has {span(seconds)}, of which one is taken, {key}date={middle}"]


def _listed(file: WeatherFile) -> str:
    names = list(file.table.columns)
    return ", ".join(names[:_MOST_LISTED]) + (", ..." if len(names) > _MOST_LISTED else "")


def _no_light(file: WeatherFile, light: set[str], key: str) -> str:
    unclear = headings.unclear_light(file.table)
    if unclear:
        return (
            f"no column 'irradiance_w_m2' [W/m2], and {unclear[0]!r} may be light on the panel or on the horizontal; "
            f"say which, {headings.spelled(key, 'irradiance_w_m2', unclear[0])} or "
            f"{headings.spelled(key, 'ghi', unclear[0])}"
        )
    has = f"only {' and '.join(sorted(light))} of the light" if light else "no column of light"
    return (
        f"no column 'irradiance_w_m2' [W/m2] on the panel nor enough on the horizontal (ghi, or dni and dhi): "
        f"it has {has}; {_spelled(key, 'ghi')}"
    )


def _no_place(file: WeatherFile, key: str) -> list[str]:
    """Ask for what the sun's way needs: a place, and dates."""
    header, own = file.header, file.own
    if own.place is None and (header.latitude_deg is None or header.longitude_deg is None):
        return [
            "it does not say where it was measured, which the sun's way needs; "
            f"'{key}place={{latitude_deg: 50.0, longitude_deg: 8.0, altitude_m: 100, utc_offset_h: 1}}'"
        ]
    return (
        [] if file.clock.dated else ["its times have no date, which the sun's way needs; give them as 2015-03-20T06:30"]
    )


def _no_offset(file: WeatherFile, transposed: bool, key: str) -> list[str]:
    """Ask how local time stands to the times of the file, where these are universal or the sun's way needs it."""
    clock, header = file.clock, file.header
    if not clock.dated or zone_of(file) is not None:
        return []
    unsaid = bool(np.isnan(clock.offset_s).all())
    if (unsaid and not transposed) or (not unsaid and np.nansum(np.abs(clock.offset_s)) > 0.0):
        return []
    if transposed and file.own.place is None and (header.latitude_deg is None or header.longitude_deg is None):
        return []  # the place is asked for, which says it
    guess = round((header.longitude_deg or 0.0) / 15.0)
    place = (
        f"'{key}place={{latitude_deg: {header.latitude_deg:g}, longitude_deg: {header.longitude_deg or 0.0:g}, "
        f"altitude_m: {header.altitude_m or 0.0:g}, utc_offset_h: {guess}}}'"
        if header.latitude_deg is not None
        else f"{key}time_zone=Europe/Berlin"
    )
    if unsaid:
        return [
            f"it does not say how its times stand to universal time; {place}, or {key}time_zone=UTC where they are it"
        ]
    return [
        f"its times are in universal time, from {_first(file)} on; give utc_offset_h, local time less universal time "
        f"[h], 0 where they are the same: {key}utc_offset_h={guess}, say; or {place}"
    ]


def _first(file: WeatherFile) -> str:
    walls = file.clock.wall_s[~np.isnan(file.clock.wall_s)]
    return f"{np.datetime64(int(walls[0]), 's')}Z" if len(walls) else "their first"


def _spelled(key: str, name: str) -> str:
    return headings.spelled(key, name, "HEADING")
