"""Weather as columns over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.panel.records import Weather


class Conditions(NamedTuple):
    """Irradiance and cell temperature, each constant from its time to the next."""

    time_s: NDArray[np.float64]
    irradiance_w_m2: NDArray[np.float64]
    cell_temperature_c: NDArray[np.float64]


def conditions(weather: Weather) -> Conditions:
    """Return the weather as columns.

    Arguments
    ---------
    weather : the record.

    Returns
    -------
    Columns of one length; a single row for constant weather.
    """
    return Conditions(np.array([0.0]), np.array([weather.irradiance_w_m2]), np.array([weather.cell_temperature_c]))
