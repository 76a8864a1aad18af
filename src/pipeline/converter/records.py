"""What the converters and the load on the bus are; light to import."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.converter.loss_records import ChainLosses, ConverterOfParts
from pipeline.converter.switched_records import SwitchedStage
from pipeline.record import Record


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


class Load(Record):
    """The master system, which the bus serves before the battery."""

    title: str = Field(min_length=1, description="name of the load, for people")
    power_w: float = Field(ge=0, description="power drawn from the bus [W]")
