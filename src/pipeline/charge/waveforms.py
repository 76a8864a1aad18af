"""The waveforms a phase may have; a new one is a class here and a line in `WAVEFORMS`.

A parameter that is not given is taken from the mode's knob of the same name; text names another knob.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Annotated, ClassVar, NamedTuple, Self

from pydantic import Field, model_validator

from pipeline.grnn.charger_network import ChargerNetwork
from pipeline.record import Record, Reference

Value = float | str | None
"""A number, the name of a knob, or none for the knob of the parameter's own name."""

PER_CAPACITY, PER_CELL = "capacity", "cells"
SCALED = {"_c_rate": ("_a", PER_CAPACITY), "_v_cell": ("_v", PER_CELL), "_w_cell": ("_w", PER_CELL)}
"""Ending of a quantity that goes with any battery -> that of the battery's own, and what it is multiplied by."""


@cache
def of_battery(name: str) -> tuple[str, str | None]:
    """Return what a quantity is called for a whole battery, and what it is multiplied by to be that; none if it is."""
    for ending, (own, per) in SCALED.items():
        if name.endswith(ending):
            return name.removesuffix(ending) + own, per
    return name, None


@cache
def spellings(name: str) -> tuple[str, ...]:
    """Return the names under which a quantity of a battery may be given, its own first."""
    return (name, *(name.removesuffix(own) + ending for ending, (own, _) in SCALED.items() if name.endswith(own)))


class Segment(NamedTuple):
    """A stretch of constant demand; only a charging one heeds the voltage limit and the supply."""

    length_s: float
    current_a: float
    charging: bool


class Bounds(Record):
    """The base of limits and ends: a quantity stands there for the battery, or per cell or capacity, not both."""

    @model_validator(mode="after")
    def _once(self) -> Self:
        for name in type(self).model_fields:
            own, per = of_battery(name)
            if per is not None and getattr(self, name) is not None and getattr(self, own) is not None:
                raise ValueError(f"{own} and {name} are one quantity; give one of them")
        return self

    @property
    def given(self) -> frozenset[str]:
        """Return the quantities that are given, by their names for a whole battery."""
        return frozenset(of_battery(name)[0] for name, value in self if value is not None)


class Limit(Bounds):
    """What a charging segment may not exceed."""

    voltage_v: Value = Field(None, description="terminal voltage [V]")
    voltage_v_cell: Value = Field(None, description="the same per cell in series [V]")


class Until(Bounds):
    """What ends a phase or a charge, whichever comes first."""

    elapsed_s: Value = Field(None, description="time since its start [s]")
    soc: Value = Field(None, description="state of charge reached [1]")
    voltage_v: Value = Field(None, description="terminal voltage reached from below [V]")
    voltage_v_cell: Value = Field(None, description="the same per cell in series [V]")
    current_a: Value = Field(None, description="tail current fallen to, while the voltage is held [A]")
    current_c_rate: Value = Field(None, description="the same over the capacity in use [C-rate]")
    temperature_c: Value = Field(None, description="battery temperature reached [degC]")
    voltage_drop_v: Value = Field(
        None,
        description="terminal voltage fallen below its peak since the sheet or a supply at its limit last lowered the "
        "current; not watched while the supply is at its limit, -dV [V]",
    )
    voltage_drop_v_cell: Value = Field(None, description="the same per cell in series [V]")
    temperature_rate_k_s: Value = Field(None, description="rate of the battery temperature reached, dT/dt [K/s]")


class Waveform(Record):
    """The base of every waveform."""

    # Parameters that need no knob of their name, with what they are without one; fields that are no parameters.
    optional: ClassVar[Mapping[str, float]] = {}
    no_parameters: ClassVar[frozenset[str]] = frozenset()
    holds_voltage: ClassVar[bool] = False
    holds_power: ClassVar[bool] = False
    periodic: ClassVar[bool] = False

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return the segments of one period, or a single endless one.

        Arguments
        ---------
        values : the waveform's parameters as numbers.
        """
        raise NotImplementedError


class ConstantCurrent(Waveform):
    """A constant current."""

    current_a: Value = Field(None, description="current [A]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return one endless segment."""
        return [Segment(math.inf, values["current_a"], True)]


class ConstantVoltage(Waveform):
    """A constant voltage, reached and held with no more than a maximum current."""

    holds_voltage: ClassVar[bool] = True

    voltage_v: Value = Field(None, description="voltage held [V]")
    max_current_a: Value = Field(None, description="current until then [A]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return one endless segment."""
        return [Segment(math.inf, values["max_current_a"], True)]


class ConstantPower(Waveform):
    """A constant power at the terminals, as far as current, voltage and supply allow."""

    optional: ClassVar[Mapping[str, float]] = {"max_current_a": math.inf}
    holds_power: ClassVar[bool] = True

    power_w: Value = Field(None, description="power [W]")
    max_current_a: Value = Field(None, description="current not exceeded [A]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return one endless segment."""
        return [Segment(math.inf, values["max_current_a"], True)]


class Pulse(Waveform):
    """Charge, rest, charge, rest."""

    periodic: ClassVar[bool] = True

    charge_a: Value = Field(None, description="current of the charging pulse [A]")
    charge_share: Value = Field(None, description="its share of the period [1]")
    frequency_hz: Value = Field(None, description="periods per second [Hz]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return the two segments of a period; one endless segment where nothing is left for the rest."""
        if values["charge_share"] == 1.0:
            return [Segment(math.inf, values["charge_a"], True)]
        period = 1.0 / values["frequency_hz"]
        share = values["charge_share"]
        return [Segment(share * period, values["charge_a"], True), Segment((1.0 - share) * period, 0.0, False)]


class Reflex(Waveform):
    """Charge, a short discharge, rest."""

    periodic: ClassVar[bool] = True

    charge_a: Value = Field(None, description="current of the charging pulse [A]")
    charge_share: Value = Field(None, description="its share of the period [1]")
    discharge_a: Value = Field(None, description="current of the discharging pulse, positive [A]")
    discharge_share: Value = Field(None, description="its share of the period [1]")
    frequency_hz: Value = Field(None, description="periods per second [Hz]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return the segments of a period; those of no length are left out."""
        if values["charge_share"] == 1.0:
            return [Segment(math.inf, values["charge_a"], True)]
        period = 1.0 / values["frequency_hz"]
        charge, discharge = values["charge_share"], values["discharge_share"]
        rest = 1.0 - charge if discharge == 0.0 else 1.0 - charge - discharge
        made = [
            Segment(charge * period, values["charge_a"], True),
            Segment(discharge * period, -values["discharge_a"], False),
            Segment(rest * period if rest > 1e-9 else 0.0, 0.0, False),
        ]
        return [segment for segment in made if segment.length_s > 0.0]


class Staged(Waveform):
    """Constant currents, one for each window of SOC; over the last edge the phase is done."""

    no_parameters: ClassVar[frozenset[str]] = frozenset({"soc_edges"})

    currents_a: Reference | Annotated[list[Value], Field(min_length=1)] = Field(
        description="current of each stage, or where all of them are found [A]"
    )
    soc_edges: list[float] = Field(min_length=1, description="state of charge at which each stage ends [1]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return one endless segment a stage."""
        return [Segment(math.inf, values[f"currents_a.{n}"], True) for n in range(len(self.soc_edges))]


class Sampled(Waveform):
    """A current that is decided anew at every sample of the battery's temperature, and applied one sample later.

    The sensor reads the temperature with noise, rounded to steps; dT/dt is the difference of two readings a span apart,
    or of the last two where no span is given: the unit delay of the paper.
    """

    optional: ClassVar[Mapping[str, float]] = {
        "rate_span_s": 0.0,
        "temperature_step_k": 0.0,
        "temperature_noise_k": 0.0,
        "noise_stream": 0.0,
    }

    sample_interval_s: Value = Field(None, description="time between samples, also the delay of the current [s]")
    rate_span_s: Value = Field(None, description="span over which dT/dt is differenced; 0: one sample [s]")
    temperature_step_k: Value = Field(None, description="step of the sensor's reading; 0: none [K]")
    temperature_noise_k: Value = Field(None, description="standard deviation of the sensor's noise [K]")
    noise_stream: Value = Field(None, description="seed of the noise [1]")

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return the segment from one sample to the next; its current is decided as it begins."""
        return [Segment(values["sample_interval_s"], 0.0, True)]


class Controller(Sampled):
    """The rate a network commands from temperature and dT/dt."""

    no_parameters: ClassVar[frozenset[str]] = frozenset({"network"})

    network: Reference | ChargerNetwork = Field(description="the network, or where it is found")


class RateSwitch(Sampled):
    """The plain rule: a fast current until dT/dt has once reached a rate, a trickle from then on."""

    fast_a: Value = Field(None, description="current until then [A]")
    trickle_a: Value = Field(None, description="current from then on [A]")
    trip_rate_k_s: Value = Field(None, description="rate of the measured temperature that switches [K/s]")


class Rest(Waveform):
    """No current."""

    def segments(self, values: Mapping[str, float]) -> list[Segment]:
        """Return one endless segment without current."""
        return [Segment(math.inf, 0.0, False)]


WAVEFORMS: dict[str, type[Waveform]] = {
    "constant_current": ConstantCurrent,
    "constant_voltage": ConstantVoltage,
    "constant_power": ConstantPower,
    "pulse": Pulse,
    "reflex": Reflex,
    "staged": Staged,
    "controller": Controller,
    "rate_switch": RateSwitch,
    "rest": Rest,
}
