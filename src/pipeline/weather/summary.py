"""What a day's weather comes to."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.quantity import Quantity
from pipeline.weather.measured import DARK, Gap, gaps
from pipeline.weather.records import MeasuredWeather, Weather
from pipeline.weather.sky import Array, Measured

_JOULE_PER_KWH = 3.6e6


def gaps_within(weather: Weather, columns: Mapping[str, Array], measured: Measured | None) -> list[Gap]:
    """Return the gaps of a weather's file that begin within its columns; arguments as for `quantities`."""
    if measured is None or not isinstance(weather, MeasuredWeather):
        return []
    until_s = float(columns["time_s"][-1] + columns["interval_s"][-1] + measured.clock_s[0])
    return [gap for gap in gaps(measured, weather.longest_gap_s) if gap.clock_s < until_s]


def quantities(weather: Weather, columns: Mapping[str, Array], measured: Measured | None) -> list[Quantity]:
    """Return the named numbers of a day's weather.

    Arguments
    ---------
    columns : those of the table WEATHER.
    measured : the rows of its file, where it has one.
    """
    lengths, irradiance = columns["interval_s"], columns["irradiance_w_m2"]
    missing = gaps_within(weather, columns, measured)
    dark = [gap for gap in missing if gap.filled == DARK]
    energy = float(np.sum(irradiance * lengths)) / _JOULE_PER_KWH
    return [
        Quantity("irradiation_kwh_m2", energy, "kWh/m2", "energy of the light on the panel"),
        Quantity("highest_irradiance_w_m2", float(irradiance.max()), "W/m2", "highest irradiance on the panel"),
        Quantity("length_s", float(lengths.sum()), "s", "from first to last light, or as long as the weather lasts"),
        Quantity("mean_ambient_c", float(np.average(columns["ambient_c"], weights=lengths)), "degC", "mean of the air"),
        Quantity(
            "highest_cell_temperature_c", float(columns["cell_temperature_c"].max()), "degC", "highest of the cells"
        ),
        Quantity("gaps", float(len(missing)), "1", "stretches of the file for which no row holds"),
        Quantity("gap_s", float(sum(gap.length_s for gap in missing)), "s", "their length together"),
        Quantity("dark_gaps", float(len(dark)), "1", "those too long to be interpolated, taken as dark"),
        Quantity("dark_gap_s", float(sum(gap.length_s for gap in dark)), "s", "their length together"),
    ]
