"""What a day is made of; light to import."""

from __future__ import annotations

from pydantic import Field

from pipeline.bus.records import LoadProfile, Switching
from pipeline.record import Record
from pipeline.tracker.records import AnyTracker
from pipeline.weather.records import Weather


class DayConditions(Record):
    """What a day's charge begins from and is computed with."""

    initial_soc: float = Field(ge=0, lt=1, description="state of charge at first light [1]")
    switching: Switching
    sample_interval_s: float = Field(default=60.0, ge=0.01, description="interval of the trace [s]")
    ambient_step_s: float = Field(
        default=1800.0, ge=1, le=86400, description="steps in which the air around the battery warms and cools [s]"
    )
    bus_swing_share: float = Field(
        default=0.0,
        ge=0,
        lt=1,
        description="swing of the bus voltage that may bridge the pauses of pulses, over it [1]",
    )
    longest_h: float = Field(default=24.0, gt=0, le=8760, description="end of a day whose weather does not end [h]")


class Day(DayConditions):
    """The days that are compared with each other."""

    title: str = Field(min_length=1, description="what the days have in common, for people")
    weathers: dict[str, Weather] = Field(min_length=1, description="weather of each day, by name")
    modes: tuple[str, ...] = Field(default=(), description="modes that charge; those of the study where empty")
    load: LoadProfile
    tracker: AnyTracker | None = Field(
        default=None, description="tracker that runs in closed loop; the converters' share of maximum power without"
    )

    def conditions(self) -> DayConditions:
        """Return what every charge of the days has in common."""
        return DayConditions(**{name: getattr(self, name) for name in DayConditions.model_fields})
