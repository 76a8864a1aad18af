"""What the converters are made of where they are looked at switch by switch; light to import."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field, model_validator

from pipeline.record import Record

_FASTEST_CONTROL = 0.1


class CurrentControl(Record):
    """A proportional-integral control of the mean inductor current, once a switching period, with feed-forward."""

    crossover_hz: float = Field(gt=0, description="frequency at which the loop's gain is one [Hz]")
    zero_hz: float = Field(ge=0, description="frequency below which the integral part leads; 0: proportional [Hz]")
    most_duty: float = Field(gt=0, le=1, description="largest duty it may set [1]")

    @model_validator(mode="after")
    def _slower_zero(self) -> CurrentControl:
        if self.zero_hz >= self.crossover_hz:
            raise ValueError(
                f"zero_hz is {self.zero_hz:g} Hz; it must lie below crossover_hz, {self.crossover_hz:g} Hz"
            )
        return self


class SwitchedConverter(Record):
    """What both converters have: two switches, an inductor, a capacitor at the output."""

    rectifier: Literal["synchronous", "diode_emulated"] = Field(
        description="the second switch carries current both ways, or opens when its current reaches zero"
    )
    switching_frequency_hz: float = Field(gt=0, description="switching periods per second [Hz]")
    on_resistance_ohm: float = Field(ge=0, description="resistance of the controlled switch when on [ohm]")
    rectifier_resistance_ohm: float = Field(ge=0, description="resistance of the second switch or diode [ohm]")
    rectifier_voltage_v: float = Field(ge=0, description="forward voltage while it acts as a diode [V]")
    inductance_h: float = Field(gt=0, description="inductance of the inductor [H]")
    inductor_resistance_ohm: float = Field(ge=0, description="its resistance [ohm]")
    capacitance_f: float = Field(gt=0, description="capacitance at the output [F]")
    capacitor_resistance_ohm: float = Field(gt=0, description="its equivalent series resistance [ohm]")

    @property
    def switching_period_s(self) -> float:
        """Return the length of a switching period [s]."""
        return 1.0 / self.switching_frequency_hz

    @model_validator(mode="after")
    def _filters(self) -> SwitchedConverter:
        resonance = 1.0 / (2.0 * math.pi * math.sqrt(self.inductance_h * self.capacitance_f))
        if resonance >= 0.5 * self.switching_frequency_hz:
            raise ValueError(
                f"switching_frequency_hz is {self.switching_frequency_hz:g} Hz, but inductance_h and capacitance_f "
                f"resonate at {resonance:.4g} Hz; allowed is more than twice that, or nothing is filtered"
            )
        return self


class SwitchedBuck(SwitchedConverter):
    """The converter from the bus to the battery."""

    isolates_discharge: bool = Field(description="S3 parts the battery from the output while S4 discharges it")
    control: CurrentControl

    @model_validator(mode="after")
    def _sampled(self) -> SwitchedBuck:
        allowed = _FASTEST_CONTROL * self.switching_frequency_hz
        if self.control.crossover_hz > allowed:
            raise ValueError(
                f"control.crossover_hz is {self.control.crossover_hz:g} Hz; a control once a switching period "
                f"allows up to {allowed:g} Hz, a tenth of switching_frequency_hz"
            )
        return self


class SwitchedBoost(SwitchedConverter):
    """The converter from the panel to the bus."""

    input_capacitance_f: float = Field(gt=0, description="capacitance across the panel [F]")


class SwitchedStage(Record):
    """Both converters at the resolution of their switches."""

    buck: SwitchedBuck
    boost: SwitchedBoost
    samples_per_period: int = Field(default=20, ge=4, le=200, description="samples of each switching period [1]")
