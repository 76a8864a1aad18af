"""What a trade-off compares, and the numbers that come of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from pydantic import Field, model_validator

from pipeline.charge.waveforms import Until
from pipeline.quantity import Vocabulary
from pipeline.record import Record

CONSTANT, TIMER, OWN = "constant_current", "timer", "own"
"""What stands in rows for the law of a constant current, the stop by a timer, and the sensor of a mode's own sheet."""

SAME_TIME = 1e-3
"""Share of a charge time by which nobody would call a charge slower."""


class Condition(Record):
    """What a charge begins from."""

    title: str = Field(min_length=1, description="readable name")
    ambient_c: float = Field(ge=-40, le=80, description="ambient temperature, also the battery's at the start [degC]")
    initial_soc: float = Field(ge=0, lt=1, description="state of charge at the start [1]")


class Sensor(Record):
    """A sensor of the battery's temperature; its fields are knobs of the sampled modes."""

    title: str = Field(min_length=1, description="readable name")
    sample_interval_s: float = Field(ge=1e-3, le=86400, description="time between samples [s]")
    temperature_step_k: float = Field(0.0, ge=0, description="step of the reading; 0: none [K]")
    temperature_noise_k: float = Field(0.0, ge=0, description="standard deviation of the noise [K]")
    rate_span_s: float = Field(0.0, ge=0, description="span over which dT/dt is differenced; 0: one sample [s]")


class TradeOff(Record):
    """Charge time against peak temperature: constant currents under every stop, and the modes that sample."""

    c_rates: list[float] = Field(min_length=1, description="constant currents [C-rate]")
    full_soc: float = Field(0.95, gt=0, lt=1, description="state of charge that counts as charged [1]")
    give_up_share: float = Field(2.0, gt=1, description="charge at which a constant current is given up [capacity]")
    stops: dict[str, Until] = Field(min_length=1, description="ways to stop a constant current, by name")
    timer_share: float = Field(1.0, gt=0, description="charge after which a timer stops a constant current [capacity]")
    conditions: dict[str, Condition] = Field(min_length=1, description="by name; the first is that of the paper")
    sensors: dict[str, Sensor] = Field(default_factory=dict, description="sensors tried in the first condition")
    candidate: str = Field(min_length=1, description="mode that is asked about: is it worth it?")
    rule: str = Field(min_length=1, description="mode with the plain rule")

    @model_validator(mode="after")
    def _rates(self) -> Self:
        if any(after <= before for before, after in zip([0.0, *self.c_rates], self.c_rates, strict=False)):
            raise ValueError(f"c_rates are {self.c_rates}; they must rise from above 0")
        for name, stop in self.stops.items():
            if name == TIMER:
                raise ValueError(f"stops has {TIMER!r}, which timer_share sets")
            given = [key for key, value in stop if value is not None]
            if len(given) != 1 or any(isinstance(value, str) for _, value in stop):
                raise ValueError(f"stops.{name} has {given or 'nothing'}; allowed is one number")
        return self


TRADE_OFF_NUMBERS = Vocabulary(
    {
        "{who}_time_to_full_{condition}_s": ("s", "{words}: time until charged"),
        "{who}_peak_{condition}_c": ("degC", "{words}: highest temperature"),
        "{mode}_charge_in_{condition}": ("1", "charge put in over the capacity"),
        "{rival}_c_rate_{condition}": ("1", "its current; stopped by {reason}"),
        "{mode}_time_to_full_behind_{sensor}_s": ("s", "{words} behind this sensor: time until charged"),
        "network_peak_behind_{sensor}_c": ("degC", "its highest temperature"),
        "rule_end_soc_behind_{sensor}": ("1", "state of charge at its end"),
        "constant_{rate}c_ended_by_{stop}_s": ("s", "end of the charge, {reason}"),
    }
)
"""`mode` is the network or the plain rule, `rival` a constant current, `who` any of them."""

MODES = {"network": "the network's charge", "rule": "the plain rule's charge"}

RIVALS = {
    "rival": "the fastest constant current that gets no hotter than the network",
    "coolest": "the coolest constant current that is no slower than the network",
}

WHO = MODES | RIVALS
"""Who charges, as names of numbers have it -> in words."""

_USUAL_C_RATES = tuple(step / 2.0 for step in range(1, 41))


def fields(chosen: TradeOff) -> dict[str, Iterable[object]]:
    """Return field -> the values it may take, also currents that the settings leave out."""
    return {
        "who": WHO,
        "mode": MODES,
        "rival": RIVALS,
        "condition": chosen.conditions,
        "sensor": chosen.sensors,
        "rate": {f"{rate:g}" for rate in (*chosen.c_rates, *_USUAL_C_RATES)},
        "stop": (*chosen.stops, TIMER),
    }
