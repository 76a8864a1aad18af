"""Records of the trade-off between time and temperature: what is charged, and how it is stopped."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from pipeline.charge.waveforms import Until
from pipeline.record import Record

CONSTANT, TIMER, OWN = "constant_current", "timer", "own"
"""What stands in rows for the law of a constant current, the stop by a timer, and the sensor of a mode's own sheet."""

_USUAL = tuple(step / 2.0 for step in range(1, 41))
NUMBERS = (
    "network_time_to_full_{of}_s network_peak_{of}_c network_charge_in_{of} rule_time_to_full_{of}_s rule_peak_{of}_c "
    "rule_charge_in_{of} rival_time_to_full_{of}_s rival_peak_{of}_c rival_c_rate_{of} coolest_time_to_full_{of}_s "
    "coolest_peak_{of}_c coolest_c_rate_{of}"
)
"""Names of the numbers found in each condition `of`."""
BEHIND = (
    "network_time_to_full_behind_{of}_s network_peak_behind_{of}_c rule_time_to_full_behind_{of}_s "
    "rule_end_soc_behind_{of}"
)
"""Names of the numbers found behind each sensor `of`."""
ENDED = "constant_{rate:g}c_ended_by_{stop}_s"
"""Name of the time at which a stop ends a constant current in the first condition."""


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

    def quantities(self) -> set[str]:
        """Return the names of the numbers that the trade-off could find, also of currents that it leaves out."""
        found = {name.format(of=of) for name in NUMBERS.split() for of in self.conditions}
        found |= {
            ENDED.format(rate=rate, stop=stop) for rate in {*self.c_rates, *_USUAL} for stop in (*self.stops, TIMER)
        }
        return found | {name.format(of=of) for name in BEHIND.split() for of in self.sensors}
