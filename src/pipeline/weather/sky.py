"""From a weather's record to columns over time."""

from __future__ import annotations

import numpy as np

from pipeline.panel.records import ConstantWeather
from pipeline.weather.clear_sky import day
from pipeline.weather.measured import Array, Measured, Sky, filled
from pipeline.weather.records import ClearSky, Weather

__all__ = ["Array", "Measured", "Sky", "sky_of"]


def sky_of(weather: Weather, ambient_c: float, measured: Measured | None = None) -> Sky:
    """Return the weather as columns; a day begins with its first light and ends with its last.

    Arguments
    ---------
    weather : the record.
    ambient_c : temperature of the air where the weather does not say [degC].
    measured : what the weather's file holds, where it has one.

    Raises
    ------
    UserError : a place and date without any sun.
    """
    if isinstance(weather, ConstantWeather):
        irradiance, cells = np.array([weather.irradiance_w_m2]), np.array([weather.cell_temperature_c])
        return Sky(np.zeros(1), irradiance, np.array([ambient_c]), cells, 0.0, np.inf)
    if isinstance(weather, ClearSky):
        return day(weather)
    if measured is None:
        raise ValueError(f"weather {weather.title!r} needs the rows of its file, {weather.file}")
    return filled(weather, measured)
