"""Records of the trade-off between time and temperature: what is charged, and how it is stopped."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from pipeline.charge.waveforms import Until
from pipeline.record import Record

CONSTANT = "constant_current"
"""What stands for the law in rows of constant currents."""


class Condition(Record):
    """What a charge begins from."""

    title: str = Field(min_length=1, description="readable name")
    ambient_c: float = Field(ge=-40, le=80, description="ambient temperature, also the battery's at the start [degC]")
    initial_soc: float = Field(ge=0, lt=1, description="state of charge at the start [1]")


class Sensor(Record):
    """A sensor of the battery's temperature; its fields are knobs of the sampled modes."""

    title: str = Field(min_length=1, description="readable name")
    sample_interval_s: float = Field(gt=0, description="time between samples [s]")
    temperature_step_k: float = Field(0.0, ge=0, description="step of the reading; 0: none [K]")
    temperature_noise_k: float = Field(0.0, ge=0, description="standard deviation of the noise [K]")
    rate_span_s: float = Field(0.0, ge=0, description="span over which dT/dt is differenced; 0: one sample [s]")


class TradeOff(Record):
    """Charge time against peak temperature: constant currents under every stop, and the modes that sample."""

    c_rates: list[float] = Field(min_length=1, description="constant currents [C-rate]")
    full_soc: float = Field(0.95, gt=0, lt=1, description="state of charge that counts as charged [1]")
    give_up_share: float = Field(2.0, gt=1, description="charge at which a constant current is given up [capacity]")
    stops: dict[str, Until] = Field(min_length=1, description="ways to stop a constant current, by name")
    conditions: dict[str, Condition] = Field(min_length=1, description="by name; the first is that of the paper")
    sensors: dict[str, Sensor] = Field(default_factory=dict, description="sensors tried in the first condition")
    candidate: str = Field(min_length=1, description="mode that is asked about: is it worth it?")
    rule: str = Field(min_length=1, description="mode with the plain rule")

    @model_validator(mode="after")
    def _rates(self) -> Self:
        if any(after <= before for before, after in zip([0.0, *self.c_rates], self.c_rates, strict=False)):
            raise ValueError(f"c_rates are {self.c_rates}; they must rise from above 0")
        for name, stop in self.stops.items():
            given = [key for key, value in stop if value is not None]
            if len(given) != 1 or any(isinstance(value, str) for _, value in stop):
                raise ValueError(f"stops.{name} has {given or 'nothing'}; give one number, so that it shows what it does")
        return self
