"""What the converters and the load on the bus are; light to import."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from pipeline.converter.switched_records import SwitchedStage
from pipeline.record import Record


class Converter(Record):
    """A converter known by its efficiency alone."""

    kind: Literal["efficiency"] = "efficiency"
    efficiency: float = Field(gt=0, le=1, description="output power over input power, at every load [1]")


class PowerChain(Record):
    """What lies between the panel and the battery: tracker, boost converter, bus, buck converter."""

    title: str = Field(min_length=1, description="name of the chain, for people")
    bus_voltage_v: float = Field(gt=0, description="voltage of the bus between the two converters [V]")
    tracker_efficiency: float = Field(gt=0, le=1, description="power drawn over the panel's maximum power [1]")
    boost: Converter
    buck: Converter
    switched: SwitchedStage | None = Field(default=None, description="both converters switch by switch")


class Load(Record):
    """The master system, which the bus serves before the battery."""

    title: str = Field(min_length=1, description="name of the load, for people")
    power_w: float = Field(ge=0, description="power drawn from the bus [W]")
