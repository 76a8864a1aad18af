"""Weather and loads that stand in a person's own files: what they hold, and the digest that enters a key.

A weather is one local day. Times without an offset from universal time are local; with one they are turned to
`utc_offset_h`. A load with dates must have rows on the day of the weather; one of times of day is the same every day.
"""

from __future__ import annotations

import datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import digest, series_file
from pipeline.bus.load import Drawn
from pipeline.bus.records import LoadProfile, MeasuredLoad
from pipeline.draft import plain
from pipeline.errors import UserError
from pipeline.series_clock import DAY_S
from pipeline.series_file import Allowed, Series
from pipeline.weather.records import ClearSky, MeasuredWeather, Weather
from pipeline.weather.sky import Measured

WEATHER = {
    # Pyranometers read some W/m2 below zero at night.
    "irradiance_w_m2": Allowed(-20.0, 2000.0, "W/m2"),
    "ambient_c": Allowed(-60.0, 60.0, "degC"),
    "wind_m_s": Allowed(0.0, 100.0, "m/s", needed=False),
}
LOAD = {"power_w": Allowed(0.0, 1e6, "W")}
LEAST_OF_A_DAY_W_M2 = 10.0
"""What the brightest row must reach: the darkest overcast days do, days in kW/m2 do not."""
_FEWEST = 2


def weather_rows(weather: Weather) -> Measured | None:
    """Return what a weather's file holds of its day; none where it has no file.

    Raises
    ------
    UserError : a file that cannot be used, with row, column, value and what is allowed.
    """
    if not isinstance(weather, MeasuredWeather):
        return None
    found = _weather(weather)
    columns = found.columns
    return Measured(found.clock_s, columns["irradiance_w_m2"], columns["ambient_c"], columns.get("wind_m_s"))


def date_of(weather: Weather) -> datetime.date | None:
    """Return the local day of a weather; none where it has none; errors as for `weather_rows`."""
    if isinstance(weather, ClearSky):
        return datetime.date.fromisoformat(weather.date)
    return _weather(weather).date if isinstance(weather, MeasuredWeather) else None


def load_rows(load: LoadProfile, date: datetime.date | None) -> Drawn | None:
    """Return what a load's file holds for a day, since its midnight; none where it has no file.

    Arguments
    ---------
    date : the weather's local day, where it has one.

    Raises
    ------
    UserError : as for the weather; a load with dates that are not those of the weather.
    """
    if not isinstance(load, MeasuredLoad):
        return None
    path = Path(load.file)
    found = _read(path, "load", load.utc_offset_h)
    power_w = found.columns["power_w"]
    if found.date is None:
        if found.clock_s[0] != 0.0:
            raise UserError(
                f"{path}: begins {found.clock_s[0]:g} s after midnight; a load of times of day is drawn every day and "
                "must begin at 0 s"
            )
        return Drawn(found.clock_s, power_w, repeats=True)
    remedy = "or give it in times of day, as 06:30 or in time_s, which hold every day"
    if date is None:
        raise UserError(f"{path}: has dates, {_dates(found)}, and the weather has none; date the weather, {remedy}")
    clock_s = found.clock_s + DAY_S * (found.date - date).days
    here = (clock_s >= 0.0) & (clock_s < DAY_S)
    if not here.any():
        raise UserError(f"{path}: no row on {date}, the day of the weather; it has {_dates(found)}; {remedy}")
    # What holds at midnight is the last row before it.
    rows = slice(max(0, int(np.argmax(here)) - 1), int(np.flatnonzero(here)[-1]) + 1)
    return Drawn(clock_s[rows], power_w[rows])


def settings(record: Weather | LoadProfile, name: str) -> dict[str, Any]:
    """Return a record as plain data under a name for its title; the content of its file stands in the key."""
    found: dict[str, Any] = {**plain(record), "title": name}
    if isinstance(record, MeasuredWeather | MeasuredLoad):
        found["file_sha256"] = digest.of_file(Path(record.file))
    return found


def without_digest(found: Any) -> dict[str, Any]:
    """Return settings as the record takes them."""
    return {key: value for key, value in found.items() if key != "file_sha256"}


def _read(path: Path, what: str, utc_offset_h: float | None) -> Series:
    """Return a file's series; a plan asks for it several times, and a year by the minute takes seconds to read."""
    return _read_once(path, what, utc_offset_h, digest.of_file(path) if path.is_file() else "")


@lru_cache(maxsize=8)
def _read_once(path: Path, what: str, utc_offset_h: float | None, content: str) -> Series:
    allowed, fewest = (LOAD, 1) if what == "load" else (WEATHER, _FEWEST)
    found = series_file.read(path, allowed, fewest, utc_offset_h)
    for column in (found.clock_s, *found.columns.values()):
        column.setflags(write=False)
    return found


def _weather(weather: MeasuredWeather) -> Series:
    path = Path(weather.file)
    found = _read(path, "weather", weather.utc_offset_h)
    date = None if weather.date is None else datetime.date.fromisoformat(weather.date)
    found = found._replace(date=date) if found.date is None else _one_day(path, found, date)
    most = float(found.columns["irradiance_w_m2"].max())
    if most < LEAST_OF_A_DAY_W_M2:
        raise UserError(
            f"{path}: column irradiance_w_m2: at most {most:g} W/m2 all day; allowed is a day that reaches "
            f"{LEAST_OF_A_DAY_W_M2:g} W/m2. Is the file in kW/m2?"
        )
    return found


def _one_day(path: Path, found: Series, date: datetime.date | None) -> Series:
    """Return the rows of one local day, since its midnight."""
    assert found.date is not None
    if date is None and found.clock_s[-1] >= DAY_S:
        raise UserError(f"{path}: has {_dates(found)}, and a weather is one day; choose it, date={found.date}")
    wanted = found.date if date is None else date
    clock_s = found.clock_s + DAY_S * (found.date - wanted).days
    here = (clock_s >= 0.0) & (clock_s < DAY_S)
    if int(here.sum()) < _FEWEST:
        raise UserError(
            f"{path}: {int(here.sum())} rows on date {wanted}; it has {_dates(found)}; allowed are {_FEWEST} and more"
        )
    return Series(clock_s[here], {name: column[here] for name, column in found.columns.items()}, wanted)


def _dates(found: Series) -> str:
    assert found.date is not None
    last = found.date + datetime.timedelta(days=int(found.clock_s[-1] // DAY_S))
    return f"rows on {found.date}" if last == found.date else f"rows from {found.date} to {last}"
