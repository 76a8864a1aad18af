"""What the currents of a staged charge are searched for, and how; light to import."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from pipeline.cell.records import Battery
from pipeline.errors import best_matches
from pipeline.record import Record

Reading = Literal["final", "positive", "peak"]
READINGS: tuple[Reading, ...] = ("final", "positive", "peak")
"""What `the sum of the stages' temperature rises` may mean: with their signs (the rise at the end), the rises alone
without the falls, or the highest rise at any time."""
KEPT: tuple[Reading, ...] = ("peak", "final")
"""The readings at which fronts are drawn, and which constant currents are held against."""


class Weights(Record):
    """How much time and rise count in the objective; their ratio decides."""

    time: float = Field(gt=0, description="weight of the charging time, alpha [1]")
    rise: float = Field(gt=0, description="weight of the temperature rise, beta [1]")


class Currents(Record):
    """The range every stage's current is searched in."""

    low: float = Field(gt=0, description="least current of a stage [A]")
    high: float = Field(gt=0, description="largest current of a stage [A]")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.low >= self.high:
            raise ValueError(f"low is {self.low:g}; it must lie below high, {self.high:g}")
        return self


class FrontSettings(Record):
    """How the front of time and rise is found."""

    population: int = Field(ge=4, description="charges of a generation of NSGA-II [1]")
    generations: int = Field(ge=1, description="generations of NSGA-II [1]")
    weights: int = Field(ge=3, description="weights of the scan, from time alone to rise alone [1]")


class Staging(Record):
    """The search for the currents of a staged charge."""

    title: str = Field(min_length=1, description="name, for people")
    mode: str = Field(min_length=1, description="charging mode with the printed currents: its stages are meant")
    current_a: Currents = Field(description="range of every stage's current [A]")
    rise: Reading = Field(description="what the sum of the stages' temperature rises means")
    weights: dict[str, Weights] = Field(min_length=1, description="weights by name; the searches use the first")
    searches: dict[str, dict[str, Any]] = Field(min_length=1, description="settings by name, kind first; no box")
    use: str = Field(min_length=1, description="search whose currents are charged with")
    replicates: int = Field(ge=1, description="independent runs of every search that does not say otherwise [1]")
    evaluations: int = Field(ge=10, le=10_000_000, description="charges at which the searches are compared [1]")
    starts: int = Field(ge=1, description="random starts of the local solver [1]")
    chords: int = Field(ge=0, description="random chords on which the rise is tested for convexity [1]")
    front: FrontSettings = Field(description="how the front of time and rise is found")

    @model_validator(mode="after")
    def _names(self) -> Self:
        if self.use not in self.searches:
            raise ValueError(f"use is {self.use!r}, which is no search; {best_matches(self.use, self.searches)}")
        for name, settings in self.searches.items():
            taken = [key for key in ("variables", "title") if key in settings]
            if taken:
                raise ValueError(f"searches.{name}.{taken[0]}: all searches look in the same box, current_a")
        return self


class Plan(Record):
    """The stages a search is for: what the printed mode says of them."""

    currents_a: list[float] = Field(min_length=1, description="printed currents [A]")
    soc_edges: list[float] = Field(min_length=2, description="SOC at the start and at the end of each stage [1]")
    voltage_v: float = Field(gt=0, description="highest voltage of the battery allowed [V]")
    temperature_c: float = Field(description="highest temperature of the battery allowed [degC]")
    ambient_c: float = Field(description="ambient temperature, also the battery's at the start [degC]")

    @model_validator(mode="after")
    def _each_one(self) -> Self:
        if len(self.soc_edges) != len(self.currents_a) + 1:
            raise ValueError(f"{len(self.currents_a)} currents but {len(self.soc_edges) - 1} stages; give one each")
        return self


class StagingProblem(Record):
    """What one search minimises."""

    battery: Battery
    plan: Plan
    current_a: Currents
    rise: Reading
    weights: Weights
