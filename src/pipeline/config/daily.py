"""Weather and days: what a study asks of the sun, and of files of its own, checked before anything runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from pipeline import own_series
from pipeline.bus.records import LoadProfile, MeasuredLoad
from pipeline.charge import checks
from pipeline.charge.records import ChargeSettings
from pipeline.errors import UserError, best_matches
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C, ConstantWeather
from pipeline.weather.records import MeasuredWeather, Weather

if TYPE_CHECKING:
    from pipeline.config.study import Study


def brightest(weather: Weather) -> tuple[float, float]:
    """Return irradiance [W/m2] and cell temperature [degC] of the brightest moment, about."""
    if isinstance(weather, ConstantWeather):
        return weather.irradiance_w_m2, weather.cell_temperature_c
    return REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C


def check(study: Study) -> None:
    """Refuse files that cannot be used, modes that do not run, and a day that no mode can begin.

    Raises
    ------
    UserError : with the key path, and below it what the file says.
    """
    if study.weather is not None:
        _weather_file("weather", study.weather)
    if study.day is None:
        return
    if study.panel is None:
        raise UserError("day: a study without a panel has no day in the sun; leave it out with ~day")
    for name, weather in study.day.weathers.items():
        _weather_file(f"day.weathers.{name}", weather)
    for weather in study.day.weathers.values():
        _load_file("day.load", study.day.load, weather)
    for mode in study.day.modes:
        if mode not in study.run:
            raise UserError(f"day.modes: no mode {mode!r} among those that are run; {best_matches(mode, study.run)}")
    begins = ChargeSettings(initial_soc=study.day.initial_soc, ambient_c=study.charge.ambient_c)
    for mode in study.day.modes or study.run:
        try:
            checks.check(study.battery, study.modes[mode], begins)
        except UserError as error:
            raise UserError(
                f"day.initial_soc: {study.day.initial_soc:g} does not go with modes.{mode}.{error}"
            ) from None


def _weather_file(path: str, weather: Weather) -> None:
    with _named(path, weather):
        own_series.weather_rows(weather)


def _load_file(path: str, load: LoadProfile, weather: Weather) -> None:
    with _named(path, load):
        own_series.load_rows(load, own_series.date_of(weather))


@contextmanager
def _named(path: str, record: Weather | LoadProfile) -> Iterator[None]:
    if isinstance(record, MeasuredWeather | MeasuredLoad) and not record.file:
        raise UserError(f"{path}.file: no file is named; give a CSV or Parquet file, {path}.file=FILE")
    try:
        yield
    except UserError as error:
        raise UserError(f"{path}.file: {error}") from None
