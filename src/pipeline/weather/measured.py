"""Measured weather: its gaps, and what stands in for them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.weather.cells import cell_temperature_c
from pipeline.weather.records import MeasuredWeather
from pipeline.weather.sky import Measured, Sky

Array = NDArray[np.float64]


class Gap(NamedTuple):
    """A stretch for which no row holds, seconds since midnight of the first day."""

    start_s: float
    length_s: float


def gaps(measured: Measured, longest_gap_s: float) -> list[Gap]:
    """Return where rows lie farther apart than a row holds; the rest of such a stretch is the gap."""
    steps = np.diff(measured.clock_s)
    rows = np.flatnonzero(steps > longest_gap_s)
    return [Gap(float(measured.clock_s[row] + longest_gap_s), float(steps[row] - longest_gap_s)) for row in rows]


def filled(weather: MeasuredWeather, measured: Measured) -> Sky:
    """Return measured weather as columns, a dark row for each gap; the last row is as long as most.

    Arguments
    ---------
    weather : the record.
    measured : at least two rows of its file.
    """
    missing = gaps(measured, weather.longest_gap_s)
    clock_s = np.concatenate([measured.clock_s, [gap.start_s for gap in missing]])
    order = np.argsort(clock_s, kind="stable")
    before = np.maximum.accumulate(np.where(order < len(measured.clock_s), order, -1))
    dark = order >= len(measured.clock_s)
    irradiance = np.where(dark, 0.0, np.maximum(0.0, measured.irradiance_w_m2[before]))
    ambient = measured.ambient_c[before]
    wind = weather.wind_m_s if measured.wind_m_s is None else measured.wind_m_s[before]
    time_s = clock_s[order] - measured.clock_s[0]
    last_s = min(float(np.median(np.diff(measured.clock_s))), weather.longest_gap_s)
    return Sky(
        time_s,
        irradiance,
        ambient,
        cell_temperature_c(weather.cell_temperature, irradiance, ambient, wind),
        float(measured.clock_s[0]) % 86400.0,
        float(time_s[-1]) + last_s,
    )
