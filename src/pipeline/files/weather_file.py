"""A weather's file, whatever format it is: its table, its times, what its header says."""

from __future__ import annotations

import datetime
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from pipeline.errors import UserError
from pipeline.files import pvlib_files
from pipeline.files.clock import Clock, clock_of
from pipeline.files.content import Content, digest, is_excel, load, text_of
from pipeline.files.numbers import number
from pipeline.files.pvlib_files import BY_NAME, Header, Known, taken_for
from pipeline.files.read import of_content
from pipeline.files.table import Preamble, Table
from pipeline.files.zones import Zone, placed
from pipeline.weather.records import MeasuredWeather
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
