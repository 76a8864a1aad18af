"""Weather and loads that stand in a person's own files: what they hold, and the digest that enters a key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline import digest, series_file
from pipeline.bus.load import Drawn
from pipeline.bus.records import LoadProfile, MeasuredLoad
from pipeline.draft import plain
from pipeline.series_file import Allowed
from pipeline.weather.records import MeasuredWeather, Weather
from pipeline.weather.sky import Measured

WEATHER = {
    # Pyranometers read some W/m2 below zero at night.
    "irradiance_w_m2": Allowed(-20.0, 2000.0, "W/m2"),
    "ambient_c": Allowed(-60.0, 60.0, "degC"),
    "wind_m_s": Allowed(0.0, 100.0, "m/s", needed=False),
}
LOAD = {"power_w": Allowed(0.0, 1e6, "W")}


def weather_rows(weather: Weather) -> Measured | None:
    """Return what a weather's file holds; none where it has no file.

    Raises
    ------
    UserError : a file that cannot be used, with row, column, value and what is allowed.
    """
    if not isinstance(weather, MeasuredWeather):
        return None
    found = series_file.read(Path(weather.file), WEATHER)
    return Measured(found["clock_s"], found["irradiance_w_m2"], found["ambient_c"], found.get("wind_m_s"))


def load_rows(load: LoadProfile) -> Drawn | None:
    """Return what a load's file holds; none where it has no file; errors as for the weather."""
    if not isinstance(load, MeasuredLoad):
        return None
    found = series_file.read(Path(load.file), LOAD, fewest=1)
    return Drawn(found["clock_s"], found["power_w"])


def settings(record: Weather | LoadProfile, name: str) -> dict[str, Any]:
    """Return a record as plain data under a name for its title; the content of its file stands in the key."""
    found: dict[str, Any] = {**plain(record), "title": name}
    if isinstance(record, MeasuredWeather | MeasuredLoad):
        found["file_sha256"] = digest.of_file(Path(record.file))
    return found


def without_digest(found: Any) -> dict[str, Any]:
    """Return settings as the record takes them."""
    return {key: value for key, value in found.items() if key != "file_sha256"}
