"""What draws on the bus and how its switches are ruled; light to import."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from pipeline.converter.records import Load
from pipeline.errors import best_matches
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
