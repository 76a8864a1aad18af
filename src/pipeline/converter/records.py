"""What the converters, their parts and the load on the bus are; light to import."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.errors import UserError
from pipeline.quantity import Vocabulary
from pipeline.record import Record

_FASTEST_CONTROL = 0.1


USUAL_BUSES_V = (24.0, 36.0, 48.0, 60.0, 72.0, 96.0, 120.0, 150.0, 200.0, 300.0, 400.0)
_COLD_OPEN_CIRCUIT = 1.25 * 1.12  # of the voltage at maximum power; 35 K below 25 degC at -0.34 %/K


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


class ConverterLosses(Record):
    """Losses of one converter that do not follow from the resistances of its parts."""

    transition_time_s: float = Field(ge=0, description="time in which voltage and current overlap at an edge [s]")
    node_capacitance_f: float = Field(ge=0, description="capacitance of the switch node, charged each period [F]")
    gate_charge_c: float = Field(ge=0, description="charge of the gate at each turn-on [C]")
    gate_voltage_v: float = Field(ge=0, description="voltage of the gate driver [V]")
    core_loss_w: float = Field(ge=0, description="loss of the inductor's core at its reference ripple [W]")
    core_ripple_a: float = Field(gt=0, description="ripple, peak to peak, of that reference [A]")
    core_frequency_hz: float = Field(gt=0, description="frequency of that reference [Hz]")
    ripple_exponent: float = Field(ge=1, le=3, description="Steinmetz exponent of the flux swing [1]")
    frequency_exponent: float = Field(ge=1, le=3, description="Steinmetz exponent of the frequency [1]")
    control_power_w: float = Field(ge=0, description="what its controller takes at every load [W]")


class ChainLosses(Record):
    """Losses of both converters."""

    boost: ConverterLosses
    buck: ConverterLosses


class ConverterOfParts(Record):
    """A converter whose efficiency follows from its parts: those of `switched`, and its `losses`."""

    kind: Literal["parts"]


class Converter(Record):
    """A converter known by its efficiency alone."""

    kind: Literal["efficiency"] = "efficiency"
    efficiency: float = Field(gt=0, le=1, description="output power over input power, at every load [1]")


def _kind(value: object) -> str:
    """Return the kind of a converter; without one it is known by its efficiency."""
    kind = value.get("kind", "efficiency") if isinstance(value, dict) else getattr(value, "kind", "efficiency")
    return str(kind)


AnyConverter = Annotated[
    Annotated[Converter, Tag("efficiency")] | Annotated[ConverterOfParts, Tag("parts")], Discriminator(_kind)
]


class PowerChain(Record):
    """What lies between the panel and the battery: tracker, boost converter, bus, buck converter."""

    title: str = Field(min_length=1, description="name of the chain, for people")
    bus_voltage_v: float = Field(gt=0, description="voltage of the bus between the two converters [V]")
    tracker_efficiency: float = Field(gt=0, le=1, description="power drawn over the panel's maximum power [1]")
    boost: AnyConverter
    buck: AnyConverter
    nominal_battery_voltage_v: float = Field(
        default=13.5, gt=0, description="battery voltage at which what the buck converter can give is told [V]"
    )
    switched: SwitchedStage | None = Field(default=None, description="the parts of both converters")
    losses: ChainLosses | None = Field(default=None, description="their losses beside those of the resistances")

    @model_validator(mode="after")
    def _of_parts(self) -> PowerChain:
        asked = [name for name in ("boost", "buck") if isinstance(getattr(self, name), ConverterOfParts)]
        missing = [name for name in ("switched", "losses") if getattr(self, name) is None]
        if asked and missing:
            raise ValueError(f"{asked[0]}.kind is parts, which needs {' and '.join(missing)} beside it")
        return self

    @property
    def of_parts(self) -> bool:
        """Tell whether the efficiency of a converter follows from its parts."""
        return isinstance(self.boost, ConverterOfParts) or isinstance(self.buck, ConverterOfParts)

    def averaged(self) -> PowerChain:
        """Return the chain without the parts that the powers of hours do not depend on."""
        return self if self.of_parts else self.model_copy(update={"switched": None, "losses": None})


class Load(Record):
    """The master system, which the bus serves before the battery."""

    title: str = Field(min_length=1, description="name of the load, for people")
    power_w: float = Field(ge=0, description="power drawn from the bus [W]")


def check(panel_power_w: float, panel_voltage_v: float, chain: PowerChain, load: Load) -> None:
    """Refuse a supply that can never charge.

    Arguments
    ---------
    panel_power_w : the most the panel gives in this weather, about [W].
    panel_voltage_v : voltage of all panels at maximum power [V].
    chain : tracker, boost and buck.
    load : the master system.

    Raises
    ------
    UserError : the boost converter would have to step down, or the load takes all the bus has.
    """
    if chain.bus_voltage_v <= panel_voltage_v:
        raise UserError(
            f"converter.bus_voltage_v is {chain.bus_voltage_v:g} V; a boost converter needs a bus above the panel's "
            f"voltage at maximum power, {panel_voltage_v:g} V; a usual bus that fits is "
            f"converter.bus_voltage_v={fitting_bus_v(panel_voltage_v):g}, from which the buck converter steps down to "
            "the battery; fewer panels in series (panel.panels_in_series) have a lower voltage too"
        )
    bus_w = panel_power_w * chain.tracker_efficiency * _most(chain.boost)
    if load.power_w >= bus_w:
        raise UserError(
            f"load.power_w is {load.power_w:g} W, but the bus has at most about {bus_w:.1f} W: the battery would "
            "never be charged; lower the load, or give more irradiance or panels"
        )


def fitting_bus_v(panel_voltage_v: float) -> float:
    """Return the lowest usual voltage of a bus that a boost converter can feed from a panel [V].

    It lies above the panel's open-circuit voltage in the cold, which is about 1.4 times that at maximum power.

    Arguments
    ---------
    panel_voltage_v : voltage of all panels at maximum power [V].
    """
    least_v = _COLD_OPEN_CIRCUIT * panel_voltage_v
    steps_v = 100.0
    return next((bus_v for bus_v in USUAL_BUSES_V if bus_v >= least_v), steps_v * math.ceil(least_v / steps_v))


def _most(converter: AnyConverter) -> float:
    """Return an efficiency that a converter does not exceed."""
    return converter.efficiency if isinstance(converter, Converter) else 1.0


BOOST = Vocabulary(
    {
        "boost_duty": ("1", "duty of the boost converter with the panel at maximum power"),
        "boost_inductor_ripple_a": ("A", "ripple of its inductor current"),
        "boost_bus_ripple_v": ("V", "ripple of the bus"),
        "boost_panel_ripple_v": ("V", "ripple of the panel's voltage"),
        "boost_missed_w": ("W", "what the panel's ripple costs of its power"),
        "boost_conduction_efficiency": ("1", "power into the bus over the panel's, conduction losses alone"),
        "boost_valley_a": ("A", "least current of its inductor"),
    }
)
