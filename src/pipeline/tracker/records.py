"""What a tracker is; light to import."""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple, TypeAlias

from pydantic import Field, model_validator

from pipeline.record import Record


class _Tracker(Record):
    """What all trackers have: when they measure, how finely, and which duties they may set."""

    title: str = Field(min_length=1, description="name of the tracker, for people")
    perturbation_period_s: float = Field(ge=0.005, le=10, description="time from a measurement to the next [s]")
    measurement_bits: int = Field(
        ge=6, le=24, description="resolution of both measurements; full scale is 1.25 times V_oc and I_sc [bit]"
    )
    start_voltage_share: float = Field(
        gt=0, lt=1, description="panel voltage over the data sheet's V_oc that it starts from, also at dawn [1]"
    )
    least_duty: float = Field(ge=0.01, lt=1, description="least duty it sets [1]")
    most_duty: float = Field(gt=0, le=0.98, description="largest duty it sets [1]")

    @model_validator(mode="after")
    def _rising(self) -> _Tracker:
        if self.least_duty >= self.most_duty:
            raise ValueError(f"least_duty is {self.least_duty:g}; it must lie below most_duty, {self.most_duty:g}")
        return self


class PerturbObserve(_Tracker):
    """Go on in the direction in which the power rose, else turn back."""

    kind: Literal["perturb_observe"]
    duty_step: float = Field(gt=0, le=0.2, description="change of the duty in a period [1]")


class IncrementalConductance(_Tracker):
    """Compare dI/dV with -I/V, which are equal at maximum power."""

    kind: Literal["incremental_conductance"]
    duty_step: float = Field(gt=0, le=0.2, description="change of the duty in a period [1]")
    tolerance: float = Field(ge=0, le=0.5, description="difference over I/V at which the duty is left alone [1]")


class VariableStep(_Tracker):
    """Incremental conductance with steps in proportion to |dP/dV| (Liu et al. 2008)."""

    kind: Literal["variable_step"]
    scaling: float = Field(gt=0, le=10, description="step of the duty over |dP/dV| / I_sc [1]")
    most_duty_step: float = Field(gt=0, le=0.2, description="largest change of the duty in a period [1]")


class ConstantVoltage(_Tracker):
    """Hold the panel at a fixed voltage, whatever the weather."""

    kind: Literal["constant_voltage"]
    voltage_share: float = Field(gt=0, lt=1, description="voltage held over the data sheet's V_oc [1]")
    gain: float = Field(gt=0, lt=2, description="share of the error in the voltage mended in a period [1]")


class ParticleSwarm(_Tracker):
    """Try duties as a particle swarm does, keep the best, then perturb and observe; again when the light changes."""

    kind: Literal["particle_swarm"]
    particles: int = Field(ge=3, le=32, description="duties in the swarm [1]")
    iterations: int = Field(ge=1, le=100, description="how often each one moves [1]")
    inertia: float = Field(ge=0, lt=1, description="inertia weight W [1]")
    c1: float = Field(ge=0, le=4, description="learning constant C1, towards a particle's own best [1]")
    c2: float = Field(ge=0, le=4, description="learning constant C2, towards the swarm's best [1]")
    chaos_start: float = Field(gt=0, lt=1, description="start of the logistic map whose values weigh both [1]")
    duty_step: float = Field(gt=0, le=0.2, description="change of the duty in a period, once it has settled [1]")
    restart_share: float = Field(gt=0, lt=1, description="change of the power in a period that starts it anew [1]")
    restart_period_s: float = Field(gt=0, description="time after which it searches anew anyway [s]")

    @model_validator(mode="after")
    def _wanders(self) -> ParticleSwarm:
        if 4.0 * self.chaos_start == int(4.0 * self.chaos_start):
            raise ValueError(
                f"chaos_start is {self.chaos_start:g}, from where the map ends in a fixed point at once; "
                "allowed is anything but 0.25, 0.5 and 0.75"
            )
        return self


AnyTracker: TypeAlias = Annotated[
    PerturbObserve | IncrementalConductance | VariableStep | ConstantVoltage | ParticleSwarm,
    Field(discriminator="kind"),
]
"""Every kind of tracker there is, told apart by `kind`."""


class Scales(NamedTuple):
    """Open-circuit voltage and short-circuit current of all panels at 1000 W/m2 and 25 degC, and the bus voltage."""

    open_circuit_voltage_v: float
    short_circuit_current_a: float
    bus_voltage_v: float


def first_duty(tracker: AnyTracker, scales: Scales) -> float:
    """Return the duty at which a tracker begins: near its share of V_oc, the converter's losses left out."""
    duty = 1.0 - tracker.start_voltage_share * scales.open_circuit_voltage_v / scales.bus_voltage_v
    return min(max(duty, tracker.least_duty), tracker.most_duty)
