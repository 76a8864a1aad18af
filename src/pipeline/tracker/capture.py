"""What a tracker captures of the panels' power over any weather."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import UserError
from pipeline.tracker.loop import Course, Light, run
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source, available_power_w, of_all_panels

__all__ = ["Source", "available", "capture", "course", "light"]

Array = NDArray[np.float64]


def capture(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Array:
    """Return the mean power a tracker draws from the panels over each interval.

    The tracker starts with the panels at open circuit. In the dark it draws nothing and keeps its duty.

    Arguments
    ---------
    source : panels, boost converter and bus.
    tracker : its record.
    time_s : starts of the intervals over which the weather is constant, rising [s], shape (n,); the last interval is
        as long as the one before it, a single one a perturbation period.
    irradiance_w_m2, cell_temperature_c : the weather in each interval [W/m2], [degC], shape (n,) or one for all.

    Returns
    -------
    Captured power [W], shape (n,).

    Raises
    ------
    UserError : times that do not rise, an irradiance below zero, a number that is not finite.
    """
    rows = light(source, tracker, time_s, irradiance_w_m2, cell_temperature_c)
    return run(source, tracker, rows).energy_j / rows.length_s


def available(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> Array:
    """Return the maximum power of the panels in each interval [W], shape (n,); arguments as for `capture`."""
    return available_power_w(source, irradiance_w_m2, cell_temperature_c)


def course(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Course:
    """Return energy, and voltage, current and duty at the end of each interval; arguments as for `capture`."""
    return run(source, tracker, light(source, tracker, time_s, irradiance_w_m2, cell_temperature_c))


def light(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Light:
    """Return the weather as the closed loop takes it; arguments as for `capture`."""
    time = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
    if not time.size:
        raise UserError("time_s: no rows; at least one is needed")
    length = np.diff(time)
    wrong = ~(length > 0.0)
    if wrong.any():
        place = int(np.argmax(wrong))
        raise UserError(
            f"time_s: row {place + 1} is {time[place + 1]:g} s after {time[place]:g} s; each time must be later than "
            "the one before it"
        )
    length = np.append(length, length[-1] if length.size else tracker.perturbation_period_s)
    irradiance, temperature = (
        np.broadcast_to(np.asarray(part, dtype=np.float64), time.shape)
        for part in (irradiance_w_m2, cell_temperature_c)
    )
    diode, series = of_all_panels(source, irradiance, temperature)
    return Light(length, diode, series, np.zeros((1, 2)), 1.0, np.full(time.shape, -1, dtype=np.int64))
