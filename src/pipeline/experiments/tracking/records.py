"""What trackers are tried on, and the numbers that the trials find; light to import."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pipeline.panel.records import CellTemperature, Irradiance
from pipeline.quantity import Vocabulary
from pipeline.record import Record
from pipeline.tracker.records import AnyTracker
from pipeline.weather.records import ClearSky, CloudySky

Slope = Annotated[float, Field(ge=1e-3, le=1000, description="slope of the irradiance [W/m2/s]")]


class Ramps(Record):
    """Ramps of the irradiance, up and down between the same two levels."""

    low_w_m2: Irradiance
    high_w_m2: Irradiance
    slopes_w_m2_s: tuple[Slope, ...] = Field(min_length=1, description="slopes of the ramps [W/m2/s]")
    repetitions: tuple[Annotated[int, Field(le=1000)], ...] = Field(
        description="how often each slope goes up and down [1]"
    )
    dwell_s: float = Field(gt=0, le=600, description="time at both levels after each ramp [s]")

    @model_validator(mode="after")
    def _paired(self) -> Ramps:
        if self.low_w_m2 >= self.high_w_m2:
            raise ValueError(f"low_w_m2 is {self.low_w_m2:g}; it must lie below high_w_m2, {self.high_w_m2:g}")
        if len(self.repetitions) != len(self.slopes_w_m2_s) or min(self.repetitions) < 1:
            raise ValueError(
                f"repetitions is {list(self.repetitions)}; it must have a number from 1 up for each of the "
                f"{len(self.slopes_w_m2_s)} slopes"
            )
        return self


class Shading(Record):
    """Shadows on a string with bypass diodes."""

    scenes: dict[str, tuple[Irradiance, ...]] = Field(
        min_length=1, description="name -> irradiance of each group of cells with a bypass diode [W/m2]"
    )
    bypass_voltage_v: float = Field(ge=0, le=1.5, description="forward voltage of a bypass diode [V]")
    light_s: float = Field(gt=0, le=600, description="time in full light before the shadow falls [s]")
    shade_s: float = Field(ge=10, le=3600, description="time in the shadow [s]")

    @model_validator(mode="after")
    def _several(self) -> Shading:
        for name, levels in self.scenes.items():
            if len(levels) < 2:
                raise ValueError(f"scenes.{name} has {len(levels)} group; allowed are two and more")
        return self


class Tracking(Record):
    """The trials of the trackers."""

    cell_temperature_c: CellTemperature
    ramps: dict[str, Ramps] = Field(min_length=1)
    skies: dict[str, Annotated[ClearSky | CloudySky, Field(discriminator="kind")]] = Field(
        default_factory=dict, description="weather of the days they are tried on, by name"
    )
    shading: Shading
    shown_slope_w_m2_s: Slope = Field(description="the ramp whose course is kept [W/m2/s]")
    settled_share: float = Field(
        default=0.02, gt=0, lt=0.5, description="band about the final power in which a tracker has settled [1]"
    )
    start_w_m2: Irradiance = Field(description="irradiance before the step to 1000 W/m2, for the settling time [W/m2]")
    steady_s: float = Field(ge=10, le=3600, description="time at 1000 W/m2, the last third of which counts [s]")

    @model_validator(mode="after")
    def _shown(self) -> Tracking:
        slopes = sorted({slope for ramps in self.ramps.values() for slope in ramps.slopes_w_m2_s})
        if self.shown_slope_w_m2_s not in slopes:
            raise ValueError(f"shown_slope_w_m2_s is {self.shown_slope_w_m2_s:g}; allowed are {slopes}")
        return self


class TrackingPart(Record):
    """The trackers, and what they are tried on."""

    trackers: dict[str, AnyTracker] = Field(default_factory=dict, description="trackers that are tried, by name")
    tracking: Tracking | None = Field(default=None, description="what the trackers are tried on")


CONVERTER_NUMBERS = Vocabulary(
    {
        "{converter}_full_efficiency": ("1", "at the panel's power"),
        "{converter}_best_efficiency": ("1", "highest over load"),
        "{converter}_best_w": ("W", "input power of that load"),
        "{converter}_off_switched": ("1", "largest difference to the switches"),
    }
)

TRACKING_NUMBERS = Vocabulary(
    {
        "{tracker}_steady_efficiency": ("1", "captured at 1000 W/m2, settled"),
        "{tracker}_ripple_v": ("V", "swing of the panel's voltage there"),
        "{tracker}_ripple_w": ("W", "swing of the power of its periods there"),
        "{tracker}_start_s": ("s", "settling time from near open circuit"),
        "{tracker}_step_s": ("s", "settling time after a step"),
        "{tracker}_ramps_efficiency": ("1", "mean over the ramps of captured / available"),
        "{tracker}_worst_ramp": ("1", "the least of them"),
    }
)
