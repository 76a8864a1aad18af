"""What a check is given and what it finds; light to import."""

from __future__ import annotations

from typing import Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.record import Record

Relation = Literal["at most", "at least"]
HOLDS, BROKEN, NOT_INSTALLED, TOLD = "holds", "broken", "not installed", "told"
"""What may be found of a row; `told` is a number without a bound."""


class Row(NamedTuple):
    """A quantity of a check and the bound it must keep to; a value of None could not be computed here."""

    quantity: str
    value: float | None
    unit: str = "1"
    relation: Relation | None = None
    bound: float | None = None
    note: str = ""

    @property
    def finding(self) -> str:
        """Return whether the bound holds; a value that is no number breaks it."""
        if self.value is None:
            return NOT_INSTALLED
        if self.bound is None:
            return TOLD
        kept = self.value <= self.bound if self.relation == "at most" else self.value >= self.bound
        return HOLDS if kept else BROKEN


class Curve(NamedTuple):
    """A line of a plot: `y` over `x`, (m,) each.

    `group` names the field it is drawn in, `series` the line; `across` and `up` label the axes, with their units.
    """

    group: str
    series: str
    across: str
    up: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]


class Found(NamedTuple):
    """What a check comes to."""

    rows: list[Row]
    curves: list[Curve]


def at_most(quantity: str, value: float | None, bound: float, unit: str = "1", note: str = "") -> Row:
    """Return a row whose value may not exceed its bound."""
    return Row(quantity, value, unit, "at most", bound, note)


def at_least(quantity: str, value: float | None, bound: float, unit: str = "1", note: str = "") -> Row:
    """Return a row whose value may not fall short of its bound."""
    return Row(quantity, value, unit, "at least", bound, note)


def largest(values: NDArray[np.float64]) -> float:
    """Return the largest magnitude, infinite where a value is no number."""
    return float(np.max(np.abs(values))) if np.all(np.isfinite(values)) else float("inf")


class Conditions(Record):
    """How a battery is charged where every mode is tried on every battery."""

    current_c_rate: float = Field(gt=0, description="largest current of every mode, per capacity [1/h]")
    voltage_v: float = Field(gt=0, description="voltage limit of every mode [V]")
    initial_soc: float = Field(ge=0, lt=1, description="state of charge at the start [1]")


class FirstLaw(Record):
    """The batteries and modes that the first law is tried on."""

    duration_s: float = Field(gt=0, le=86400, description="length of every charge [s]")
    bulk_s: float = Field(gt=0, le=86400, description="length of its first phase, where that ends by time [s]")
    batteries: dict[str, Battery] = Field(min_length=1, description="batteries by name")
    conditions: dict[str, Conditions] = Field(description="battery -> how it is charged")
    modes: dict[str, Mode] = Field(min_length=1, description="modes by name")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if set(self.conditions) != set(self.batteries):
            named, needed = ", ".join(sorted(self.conditions)), ", ".join(sorted(self.batteries))
            raise ValueError(f"conditions are given for {named}; needed are those of {needed}")
        return self


class Peers(Record):
    """What independent codes are compared on."""

    current_c_rate: float = Field(gt=0, description="current of every charge, per capacity [1/h]")
    held_voltage_v: float = Field(gt=0, description="voltage held in CC-CV, where the battery has what is common [V]")


class PeerSettings(Peers):
    """The same with the battery, and what is installed here."""

    battery: Battery
    initial_soc: float = Field(ge=0, lt=1, description="state of charge at the start [1]")
    ambient_c: float = Field(description="ambient temperature, also at the start [degC]")
    version: str | None = Field(description="version of the other code; none where it is not installed")


class Validation(Record):
    """What the checks are run on; a check takes the part of its own name."""

    first_law: FirstLaw
    peers: Peers
