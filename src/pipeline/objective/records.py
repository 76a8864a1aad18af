"""What the loss against frequency is computed from; light to import."""

from __future__ import annotations

from typing import Literal, NamedTuple

from pydantic import Field, model_validator

from pipeline.record import Record


class Waveform(Record):
    """One period of charge, discharge and rest, in this order; without discharge it is a pulse."""

    charge_a: float = Field(gt=0, description="current of the charging part [A]")
    charge_share: float = Field(gt=0, le=1, description="charging share of the period [1]")
    discharge_a: float = Field(default=0.0, ge=0, description="current of the discharging part, as a magnitude [A]")
    discharge_share: float = Field(default=0.0, ge=0, lt=1, description="discharging share of the period [1]")

    @model_validator(mode="after")
    def _one_period(self) -> Waveform:
        total = self.charge_share + self.discharge_share
        if total > 1.0 + 1e-12:
            raise ValueError(f"charge_share + discharge_share is {total:g}; a period holds at most 1")
        return self


class Transistor(Record):
    """A switch and its driver, as a data sheet gives them; each turns on and off once in a period."""

    rise_time_s: float = Field(ge=0, description="overlap of voltage and current at turn-on [s]")
    fall_time_s: float = Field(ge=0, description="overlap of voltage and current at turn-off [s]")
    output_capacitance_f: float = Field(ge=0, description="output capacitance C_oss [F]")
    gate_charge_c: float = Field(ge=0, description="total gate charge Q_g [C]")
    gate_voltage_v: float = Field(ge=0, description="voltage of the gate driver [V]")
    blocked_voltage_v: float = Field(gt=0, description="voltage across the switch when it is off [V]")


class ReflexFrequency(Record):
    """The objective: integral square error of the loss that depends on the Reflex frequency."""

    kind: Literal["reflex_frequency"] = "reflex_frequency"
    title: str = Field(min_length=1, description="name of the objective, for people")
    mode: str = Field(min_length=1, description="charging mode whose waveform is meant")
    transistor: Transistor = Field(description="both switches, of the charging and of the discharging path")
    window_s: float = Field(gt=0, description="length of the window over which e(t)^2 is integrated [s]")
    soc: float = Field(ge=0, le=1, description="SOC at which the battery's resistances are taken [1]")
    discharge_voltage_v: float = Field(gt=0, description="battery voltage while the resistor discharges it [V]")
    inductance_h: float = Field(gt=0, description="inductance of battery and leads, for the impedance minimum [H]")
    classic_frequency_hz: float = Field(gt=0, description="frequency of the classic Reflex charge [Hz]")
    band_share: float = Field(gt=0, description="the band within which the integral exceeds its minimum by this [1]")


class Pairs(NamedTuple):
    """The battery's RC pairs as plain values, one entry per pair; slow and fast alike."""

    resistance_ohm: tuple[float, ...]
    time_constant_s: tuple[float, ...]


class Problem(Record):
    """All that the integral square error depends on: what a search is given."""

    waveform: Waveform
    pairs: Pairs = Field(description="of the whole battery")
    transistor: Transistor
    window_s: float = Field(gt=0, description="length of the window over which e(t)^2 is integrated [s]")
