"""A weather that stands in a user's file: one local day of it, brought onto the panel."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files import headings, quantities
from pipeline.files.days import Day, Rows, day_of
from pipeline.files.headings import Found, values
from pipeline.files.pvlib_files import Header
from pipeline.files.weather_file import WeatherFile, ask, opened, transposed, zone_of
from pipeline.weather.measured import DARK, Measured, gaps, longest_gap_s
from pipeline.weather.records import LIGHT, ClearSky, MeasuredWeather, Place, Surface, Weather
from pipeline.weather.transposition import OnPanel, Parts, Site, on_panel

Array = NDArray[np.float64]
_FEWEST = 2
_MOST_AT_NIGHT = 0.1
_QUANTITIES = {one.name: one for one in quantities.WEATHER}


class WeatherDay(NamedTuple):
    """What a weather's file holds of its day: the rows, the local date if there is one, and what was found."""

    measured: Measured
    date: datetime.date | None
    said: tuple[str, ...]


def weather_rows(weather: Weather, key: str = "weather") -> Measured | None:
    """Return what a weather's file holds of its day; none where it has no file.

    Arguments
    ---------
    weather : the record.
    key : its key path, for messages.

    Raises
    ------
    UserError : a file that cannot be used, with row, column, value, what is allowed, and the override that mends it.
    """
    return weather_day(weather, key).measured if isinstance(weather, MeasuredWeather) else None


def date_of(weather: Weather, key: str = "weather") -> datetime.date | None:
    """Return the local day of a weather; none where it has none; arguments and errors as for `weather_rows`."""
    if isinstance(weather, ClearSky):
        return datetime.date.fromisoformat(weather.date)
    return weather_day(weather, key).date if isinstance(weather, MeasuredWeather) else None


def told(weather: Weather, key: str = "weather") -> tuple[str, ...]:
    """Return what was found in a weather's file and how its light came onto the panel, in sentences, for the page."""
    if not isinstance(weather, MeasuredWeather):
        return ()
    day = weather_day(weather, key)
    return (*day.said, *_dark_by_day(weather, day.measured, key))


def _dark_by_day(weather: MeasuredWeather, measured: Measured, key: str) -> list[str]:
    """Say which gaps count as dark although it was light when they began or ended."""
    said = []
    for gap in gaps(measured, longest_gap_s(weather, measured)):
        after = int(np.searchsorted(measured.clock_s, gap.clock_s + 0.5 * gap.length_s))
        lit = float(measured.irradiance_w_m2[after - 1 : after + 1].max()) > 0.0
        if gap.filled == DARK and lit:
            hours, minutes = divmod(round(gap.clock_s / 60.0), 60)
            said.append(
                f"no rows for {gap.length_s:.0f} s from {hours:02d}:{minutes:02d} on, which count as dark; "
                f"{key}.longest_gap_s={gap.length_s:.0f} has them interpolated"
            )
    return said


def weather_day(weather: MeasuredWeather, key: str = "weather") -> WeatherDay:
    """Return the day of a weather's file; arguments and errors as for `weather_rows`."""
    dotted = f"{key}." if key else ""
    file = opened(weather, dotted)
    found = headings.match(file.table, file.own, quantities.WEATHER, dotted)
    ask(file, found, dotted)
    wanted = None if weather.date is None else datetime.date.fromisoformat(weather.date)
    _refuse_offset(file)
    asked = Rows(file.table, dotted, wanted, zone_of(file), weather.label, _FEWEST)
    day = day_of(file.clock, asked)
    if not file.clock.dated and not file.own.units.keys() & {"time", "time_s"}:
        quantities.refuse_short(file.table.path, file.clock.column, day.start_s, day.step_s, dotted)
    columns, said = _columns(file, found, day, dotted)
    used = _lights(file.own, set(columns))
    measured, how = _measured(file, found, day, columns, used, dotted)
    return WeatherDay(measured, day.date, (*file.said, *found.said, *said, *day.said, how))


def _lights(own: MeasuredWeather, names: set[str]) -> set[str]:
    light = names & set(LIGHT)
    return light - {"irradiance_w_m2"} if transposed(own, light) else {"irradiance_w_m2"}


def _refuse_offset(file: WeatherFile) -> None:
    own, clock = file.own, file.clock
    if own.utc_offset_h is None or own.place is not None or file.header.utc_offset_h is not None:
        return
    if not clock.dated or np.isnan(clock.offset_s).all():
        raise UserError(
            f"{file.table.path}: its times carry no offset from universal time and are local; utc_offset_h is "
            f"{own.utc_offset_h:g}, allowed is null, or times as 2015-03-20T06:30:00Z"
        )


def _columns(file: WeatherFile, found: Found, day: Day, key: str) -> tuple[dict[str, Array], list[str]]:
    """Return the values of the day's rows of every column that is used."""
    light = _lights(file.own, set(found.headings))
    lengths = np.full(len(day.rows), day.step_s)
    columns: dict[str, Array] = {}
    said: list[str] = []
    for name, heading in found.headings.items():
        if name in LIGHT and name not in light:
            continue
        columns[name], more = values(file.table, file.own, _QUANTITIES[name], heading, day.rows.tolist(), lengths, key)
        said += more
    return columns, said


def _measured(
    file: WeatherFile, found: Found, day: Day, columns: Mapping[str, Array], light: set[str], key: str
) -> tuple[Measured, str]:
    if len(day.rows) < _FEWEST:
        raise UserError(f"{file.table.path}: {len(day.rows)} rows; allowed are {_FEWEST} and more")
    known = np.all([~np.isnan(columns[name]) for name in sorted(light)], axis=0)
    if int(known.sum()) < _FEWEST:
        raise UserError(
            f"{file.table.path}: {int(known.sum())} rows of the day have light; allowed are {_FEWEST} and more"
        )
    brightest = max(sorted(light), key=lambda name: float(np.nanmax(columns[name])))
    if file.own.units.get(brightest) is None:
        heading = found.headings[brightest]
        quantities.refuse_dark(file.table.path, heading, brightest, columns[brightest][known], key)
    if light == {"irradiance_w_m2"}:
        irradiance, how = columns["irradiance_w_m2"][known], "light on the panel as the file has it"
    else:
        parts = Parts(**{name: columns[name][known] for name in light})
        made = _transpose(file, day, parts, known)
        if made.night_share > _MOST_AT_NIGHT:
            raise UserError(
                f"{file.table.path}: {100 * made.night_share:.0f} % of the day's light comes while the sun is down; "
                f"are its times local time, or its place another? {key}place={{...}}, {key}utc_offset_h or "
                f"{key}time_zone say it"
            )
        irradiance, how = made.irradiance_w_m2, f"{made.how}, brought onto the panel by Hay and Davies (1980)"
    air = _filled(columns.get("ambient_c"), known, file.own.ambient_c)
    assert air is not None
    wind = _filled(columns.get("wind_m_s"), known, file.own.wind_m_s) if "wind_m_s" in columns else None
    return Measured(day.start_s[known], irradiance, air, wind, day.step_s if day.date else None), how


def _transpose(file: WeatherFile, day: Day, parts: Parts, known: NDArray[np.bool_]) -> OnPanel:
    own, header = file.own, file.header
    place: Place | Header = header if own.place is None else own.place
    surface = own.surface
    assert isinstance(surface, Surface)
    assert day.universal_s is not None
    assert place.latitude_deg is not None
    assert place.longitude_deg is not None
    site = Site(place.latitude_deg, place.longitude_deg, place.altitude_m or 0.0)
    return on_panel(parts, day.universal_s[known], site, surface)


def _filled(column: Array | None, known: NDArray[np.bool_], constant: float | None) -> Array | None:
    """Return a column of the rows with light, interpolated where nothing was measured; a constant where never."""
    if column is None or np.isnan(column).all():
        return None if constant is None else np.full(int(known.sum()), constant)
    places = np.arange(len(column))
    there = ~np.isnan(column)
    return np.interp(places[known], places[there], column[there])


def source_name(weather: MeasuredWeather) -> str:
    """Return the name of a weather's file, for a page."""
    return Path(weather.file).name
