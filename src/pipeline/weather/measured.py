"""Measured weather: its gaps, and what stands in for them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.weather.records import MeasuredWeather
from pipeline.weather.transposition import cell_temperature_c


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
    """What a file holds of its day: starts since midnight, light on the panel, air, shape (n,); wind where it has it.

    `step_s` is the file's own interval, where it is known better than from the rows of the day alone [s].
    """

    clock_s: Array
    irradiance_w_m2: Array
    ambient_c: Array
    wind_m_s: Array | None = None
    step_s: float | None = None


Array = NDArray[np.float64]

INTERPOLATED, DARK = "interpolated", "dark"
_LATE = 1.5
"""A row is missing where the next one comes later than so many usual distances."""


class Gap(NamedTuple):
    """A stretch for which no row holds: start since midnight and length [s], and what stands in for it."""

    clock_s: float
    length_s: float
    filled: str


def usual_interval_s(measured: Measured) -> float:
    """Return the file's interval, for which each of its rows holds [s]: known, or the median distance of two rows."""
    return measured.step_s or float(np.median(np.diff(measured.clock_s)))


def gaps(measured: Measured, longest_gap_s: float) -> list[Gap]:
    """Return where rows are missing; up to the longest gap they are interpolated, beyond it the gap is dark."""
    usual_s, steps = usual_interval_s(measured), np.diff(measured.clock_s)
    found = []
    for row in np.flatnonzero(steps > _LATE * usual_s).tolist():
        length_s = float(steps[row]) - usual_s
        filled = INTERPOLATED if length_s <= longest_gap_s + 1e-6 * usual_s else DARK
        found.append(Gap(float(measured.clock_s[row]) + usual_s, length_s, filled))
    return found


def longest_gap_s(weather: MeasuredWeather, measured: Measured) -> float:
    """Return the longest gap that is interpolated, by the weather's time and by its rows, whichever is longer [s]."""
    return weather.longest_gap(usual_interval_s(measured))


def filled(weather: MeasuredWeather, measured: Measured) -> Sky:
    """Return measured weather as columns, rows put into its gaps at the usual distance.

    There air and wind are interpolated, and so is the light in short gaps; in long ones it is dark.

    Arguments
    ---------
    weather : the record.
    measured : at least two rows of its file.
    """
    usual_s = usual_interval_s(measured)
    missing = gaps(measured, longest_gap_s(weather, measured))
    put_in = [gap.clock_s + np.arange(0.0, gap.length_s - 1e-6 * usual_s, usual_s) for gap in missing]
    clock_s = np.sort(np.concatenate([measured.clock_s, *put_in]))

    def column(values: Array) -> Array:
        return np.asarray(np.interp(clock_s, measured.clock_s, values), dtype=np.float64)

    irradiance = column(np.maximum(0.0, measured.irradiance_w_m2))
    for gap, times in zip(missing, put_in, strict=True):
        if gap.filled == DARK:
            irradiance[np.isin(clock_s, times)] = 0.0
    ambient = column(measured.ambient_c)
    wind = weather.wind_m_s if measured.wind_m_s is None else column(measured.wind_m_s)
    time_s = clock_s - clock_s[0]
    return Sky(
        time_s,
        irradiance,
        ambient,
        cell_temperature_c(weather.cell_temperature, irradiance, ambient, wind),
        float(clock_s[0]),
        float(time_s[-1]) + usual_s,
    )
