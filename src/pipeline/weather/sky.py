"""From a weather's record to columns over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.panel.records import ConstantWeather
from pipeline.weather.records import ClearSky, Weather

Array = NDArray[np.float64]


class Sky(NamedTuple):
    """The weather from a time 0 on, each row constant until the next.

    Arguments
    ---------
    time_s : starts of the rows, rising from 0 [s], shape (n,).
    irradiance_w_m2, ambient_c, cell_temperature_c : on the panel, of the air, of the cells, shape (n,).
    clock_s : local time at time 0, since midnight [s].
    end_s : end of the last row; inf where the weather does not end [s].
    """

    time_s: Array
    irradiance_w_m2: Array
    ambient_c: Array
    cell_temperature_c: Array
    clock_s: float
    end_s: float


class Measured(NamedTuple):
    """What a file holds of its day: seconds since midnight, shape (n,); no wind where it has none."""

    clock_s: Array
    irradiance_w_m2: Array
    ambient_c: Array
    wind_m_s: Array | None = None


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
        from pipeline.weather.clear_sky import day

        return day(weather)
    from pipeline.weather.measured import filled

    if measured is None:
        raise ValueError(f"weather {weather.title!r} needs the rows of its file, {weather.file}")
    return filled(weather, measured)
