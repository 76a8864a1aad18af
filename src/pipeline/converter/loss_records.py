"""What a converter loses beside its resistances: switching, core, control; light to import."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from pipeline.record import Record


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
