"""What draws on the bus and how its switches are ruled; the power that a load asks for over time."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from pipeline.converter.records import Load
from pipeline.errors import UserError, best_matches
from pipeline.record import OwnFile, Record


class FromHour(Record):
    """A power from an hour on."""

    from_h: float = Field(ge=0, lt=24, description="local time from which it is drawn [h]")
    power_w: float = Field(ge=0, description="power drawn from the bus [W]")


def _in_order(hours: tuple[FromHour, ...]) -> None:
    starts = [row.from_h for row in hours]
    if starts[0] != 0.0:
        raise ValueError(f"hours begin at {starts[0]:g} h; the first row must begin at 0")
    for before, after in pairwise(starts):
        if after <= before:
            raise ValueError(f"hours go from {before:g} h to {after:g} h; each row must begin after the one before")


class HourlyLoad(Record):
    """A load that follows the clock, the same every day."""

    kind: Literal["hours"] = "hours"
    title: str = Field(min_length=1, description="name of the load, for people")
    hours: tuple[FromHour, ...] = Field(min_length=1, description="powers in the order of the day, the first from 0 h")

    @model_validator(mode="after")
    def _in_order(self) -> HourlyLoad:
        _in_order(self.hours)
        return self


Weekday: TypeAlias = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
WEEKDAYS: tuple[Weekday, ...] = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


class DayProfile(Record):
    """The powers of a kind of day: those of some weekdays in some months."""

    months: tuple[Annotated[int, Field(ge=1, le=12)], ...] = Field(
        default=tuple(range(1, 13)), min_length=1, description="months in which it holds, January being 1 [1]"
    )
    weekdays: tuple[Weekday, ...] = Field(
        default=WEEKDAYS, min_length=1, description="days of the week on which it holds"
    )
    hours: tuple[FromHour, ...] = Field(min_length=1, description="powers in the order of the day, the first from 0 h")

    @model_validator(mode="after")
    def _in_order(self) -> DayProfile:
        _in_order(self.hours)
        return self


class ProfileLoad(Record):
    """A load by hour, weekday and month; the first profile that holds on a day is that day's."""

    kind: Literal["profile"] = "profile"
    title: str = Field(min_length=1, description="name of the load, for people")
    profiles: tuple[DayProfile, ...] = Field(
        min_length=1, description="kinds of days; the first that fits a day counts"
    )

    @model_validator(mode="after")
    def _every_day(self) -> ProfileLoad:
        for month in range(1, 13):
            for weekday in WEEKDAYS:
                if not any(month in one.months and weekday in one.weekdays for one in self.profiles):
                    raise ValueError(
                        f"profiles have none for a {weekday} in month {month}; the last may leave both out"
                    )
        return self


LOAD_COLUMNS = ("time", "time_s", "date", "power_w", "power", "month", "weekday", "hour")


class MeasuredLoad(OwnFile):
    """A file of power over time, or of energy in each interval; each row holds until the next, the last one on.

    With times of day it is the same every day and begins at midnight; with dates it has rows on the day of the weather,
    and one no later than the weather's first; with columns of hour, and perhaps weekday and month, and no other times
    it is a profile.
    """

    kind: Literal["table"] = "table"
    title: str = Field(min_length=1, description="name of the load, for people")

    @field_validator("columns", "units")
    @classmethod
    def _known(cls, value: dict[str, str]) -> dict[str, str]:
        for name in value:
            if name not in LOAD_COLUMNS:
                raise ValueError(f"{name!r} is no quantity of a load; {best_matches(name, LOAD_COLUMNS)}")
        return value


def _kind(value: Any) -> str:
    found = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    return "constant" if found is None else str(found)


LoadProfile: TypeAlias = Annotated[
    Annotated[Load, Tag("constant")]
    | Annotated[HourlyLoad, Tag("hours")]
    | Annotated[ProfileLoad, Tag("profile")]
    | Annotated[MeasuredLoad, Tag("table")],
    Discriminator(_kind),
]
"""Every kind of load; a constant one is what the studies' charges take."""


class Switching(Record):
    """When the bus lets the charger draw: above one surplus it begins, below a lower one it stops."""

    start_power_w: float = Field(gt=0, description="power left for the battery's terminals that begins charging [W]")
    stop_power_w: float = Field(gt=0, description="power below which charging stops [W]")

    @model_validator(mode="after")
    def _hysteresis(self) -> Switching:
        if self.stop_power_w > self.start_power_w:
            raise ValueError(
                f"stop_power_w is {self.stop_power_w:g} W; it must not lie above start_power_w, "
                f"{self.start_power_w:g} W"
            )
        return self


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
