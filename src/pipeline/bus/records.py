"""What hangs on the bus and what switches it; light to import."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.converter.records import Load
from pipeline.record import Record
from pipeline.series_clock import FileOffset


class FromHour(Record):
    """A power from an hour on."""

    from_h: float = Field(ge=0, lt=24, description="local time from which it is drawn [h]")
    power_w: float = Field(ge=0, description="power drawn from the bus [W]")


class HourlyLoad(Record):
    """A load that follows the clock, the same every day."""

    kind: Literal["hours"] = "hours"
    title: str = Field(min_length=1, description="name of the load, for people")
    hours: tuple[FromHour, ...] = Field(min_length=1, description="powers in the order of the day, the first from 0 h")

    @model_validator(mode="after")
    def _in_order(self) -> HourlyLoad:
        starts = [row.from_h for row in self.hours]
        if starts[0] != 0.0:
            raise ValueError(f"hours begin at {starts[0]:g} h; the first row must begin at 0")
        for before, after in pairwise(starts):
            if after <= before:
                raise ValueError(f"hours go from {before:g} h to {after:g} h; each row must begin after the one before")
        return self


class MeasuredLoad(Record):
    """A CSV or Parquet file: time_s or time (ISO 8601), power_w; each row holds until the next, the last one on.

    With times of day it is the same every day and begins at midnight; with dates it has rows on the day of the weather,
    and one no later than the weather's first.
    """

    kind: Literal["table"] = "table"
    title: str = Field(min_length=1, description="name of the load, for people")
    file: str = Field(description="CSV or Parquet file; relative paths start from the working folder")
    utc_offset_h: FileOffset = None


def _kind(value: Any) -> str:
    found = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    return "constant" if found is None else str(found)


LoadProfile: TypeAlias = Annotated[
    Annotated[Load, Tag("constant")] | Annotated[HourlyLoad, Tag("hours")] | Annotated[MeasuredLoad, Tag("table")],
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
