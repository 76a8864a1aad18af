"""The load's power over time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.bus.records import HourlyLoad, LoadProfile, MeasuredLoad
from pipeline.converter.records import Load
from pipeline.errors import UserError

Array = NDArray[np.float64]
_DAY_S = 86400.0


class Drawn(NamedTuple):
    """Power over time, each row until the next: seconds since midnight [s], power [W], shape (n,) each.

    What `repeats` is the same every day, and begins at midnight.
    """

    clock_s: Array
    power_w: Array
    repeats: bool = False


def drawn(load: LoadProfile, from_s: float, until_s: float, measured: Drawn | None = None) -> Drawn:
    """Return what a load draws between two times.

    Arguments
    ---------
    load : the record.
    from_s, until_s : times since midnight of the first day [s]; the first row is at the first.
    measured : what the load's file holds, where it has one.

    Raises
    ------
    UserError : a file that says nothing of the first time.
    """
    if isinstance(load, Load):
        return Drawn(np.array([from_s]), np.array([load.power_w]))
    if isinstance(load, HourlyLoad):
        found = Drawn(
            np.array([3600.0 * row.from_h for row in load.hours]), np.array([row.power_w for row in load.hours]), True
        )
    elif measured is None:
        raise ValueError(f"load {load.title!r} needs what its file or its profiles hold of the day")
    else:
        found = measured
        if found.clock_s[0] > from_s:
            raise UserError(
                f"{_named(load)}: begins {found.clock_s[0]:g} s after midnight, the weather at {from_s:g} s; allowed "
                "is a first row no later than that"
            )
    if found.repeats:
        days = np.arange(np.floor(from_s / _DAY_S), np.floor(until_s / _DAY_S) + 1.0)
        found = Drawn((days[:, None] * _DAY_S + found.clock_s).ravel(), np.tile(found.power_w, len(days)))
    first = int(np.searchsorted(found.clock_s, from_s, side="right")) - 1
    last = max(first + 1, int(np.searchsorted(found.clock_s, until_s, side="left")))
    clock_s = found.clock_s[first:last].copy()
    clock_s[0] = from_s
    return Drawn(clock_s, found.power_w[first:last])


def _named(load: LoadProfile) -> str:
    return load.file if isinstance(load, MeasuredLoad) else f"load {load.title!r}"


def held(starts: ArrayLike, values: ArrayLike, at: ArrayLike) -> Array:
    """Return what is held at times: the value of the last row that has begun, shape of `at`."""
    rows = np.searchsorted(np.asarray(starts, dtype=float), np.asarray(at, dtype=float), side="right") - 1
    return np.asarray(values, dtype=np.float64)[np.maximum(rows, 0)]
