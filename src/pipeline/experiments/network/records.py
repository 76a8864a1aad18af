"""The network in the configuration: what it learns from, how it is chosen, what it is held against."""

from __future__ import annotations

import itertools
from typing import Literal, Self

from pydantic import Field, model_validator

from pipeline.grnn.records import AnfisSettings, Kernel, Method, Widths
from pipeline.record import Record
from pipeline.search.genetic import GeneticSettings

GradientUnit = Literal["k_min", "k_s"]
SurfaceName = Literal["plateau_steps", "plateau_ramp", "sigmoid", "takagi_sugeno"]
USED: Literal["genetic"] = "genetic"
"""Name of the network that is used."""
LONG = "genetic_long"
"""Name of the network that the genetic algorithm ends with beyond the generations that are used."""
GRADIENT_SECONDS: dict[GradientUnit, float] = {"k_min": 60.0, "k_s": 1.0}
"""Seconds in each unit of dT/dt."""


def gradient_unit(seconds: float) -> str:
    """Return the unit of dT/dt for people; `seconds` are those in the unit."""
    return {60.0: "K/min", 1.0: "K/s"}.get(seconds, f"K per {seconds:g} s")


class Grid(Record):
    """Where the data's points lie: every temperature with every gradient."""

    highest_temperature_c: float = Field(gt=0, description="highest temperature; the lowest is 0 degC [degC]")
    temperatures: int = Field(ge=2, description="evenly spaced temperatures, both ends included [1]")
    highest_gradient: float = Field(gt=0, description="highest gradient; the lowest is 0 [gradient_unit]")
    gradients: int = Field(ge=2, description="evenly spaced gradients, both ends included [1]")


class PlateauSteps(Record):
    """Rates that fall in steps at edges of temperature."""

    rates_c: tuple[float, ...] = Field(min_length=1, description="rate between edges, from cold to hot [C-rate]")
    edges_c: tuple[float, ...] = Field(description="temperatures at which it falls [degC]")

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if len(self.edges_c) != len(self.rates_c) - 1:
            raise ValueError(f"edges_c has {len(self.edges_c)} entries; {len(self.rates_c)} rates have one less")
        _rising("edges_c", self.edges_c)
        return self


class PlateauRamp(Record):
    """Rates at temperatures, with straight lines between them and constant beyond."""

    temperatures_c: tuple[float, ...] = Field(min_length=2, description="temperatures of the corners [degC]")
    rates_c: tuple[float, ...] = Field(description="rate at each [C-rate]")

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if len(self.temperatures_c) != len(self.rates_c):
            raise ValueError(f"temperatures_c has {len(self.temperatures_c)} entries, rates_c {len(self.rates_c)}")
        _rising("temperatures_c", self.temperatures_c)
        return self


class Sigmoid(Record):
    """rest + fall / (1 + exp((T - middle + lead x gradient) / slope))."""

    rest_c: float = Field(ge=0, description="rate when hot [C-rate]")
    fall_c: float = Field(gt=0, description="by how much the rate is higher when cold [C-rate]")
    middle_c: float = Field(description="temperature at half the fall, at gradient 0 [degC]")
    slope_k: float = Field(gt=0, description="temperature over which it falls by a factor e far from the middle [K]")
    lead_k: float = Field(description="by how much a gradient of 1 lowers the middle [K per gradient_unit]")


class TakagiSugeno(Record):
    """Six rules: triangles over temperature and gradient, each pair with a constant rate."""

    temperatures_c: tuple[float, ...] = Field(min_length=2, description="peaks of the triangles [degC]")
    gradients: tuple[float, ...] = Field(min_length=2, description="peaks of the triangles [gradient_unit]")
    rates_c: tuple[tuple[float, ...], ...] = Field(description="a row per temperature, a rate per gradient [C-rate]")

    @model_validator(mode="after")
    def _fit(self) -> Self:
        shape = (len(self.temperatures_c), len(self.gradients))
        if len(self.rates_c) != shape[0] or any(len(row) != shape[1] for row in self.rates_c):
            raise ValueError(f"rates_c must have {shape[0]} rows of {shape[1]}")
        _rising("temperatures_c", self.temperatures_c)
        _rising("gradients", self.gradients)
        return self


class Surfaces(Record):
    """The surfaces that stand in for the lost data."""

    plateau_steps: PlateauSteps
    plateau_ramp: PlateauRamp
    sigmoid: Sigmoid
    takagi_sugeno: TakagiSugeno


class SizeStudy(Record):
    """Error against the number of centres."""

    smallest: int = Field(ge=1, description="fewest centres [1]")
    largest: int = Field(ge=1, description="most centres [1]")
    generations: int = Field(ge=1, description="generations of each selection by the algorithm [1]")
    replicates: int = Field(ge=1, description="selections of each size [1]")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.smallest > self.largest:
            raise ValueError(f"smallest is {self.smallest}; it must not lie above largest, {self.largest}")
        return self


class KernelStudy(Record):
    """Error under every kernel on every surface."""

    generations: int = Field(ge=1, description="generations of each selection by the algorithm [1]")
    replicates: int = Field(ge=1, description="selections of each pair [1]")


class DataSettings(Record):
    """What is learnt: a surface on a grid, or a table of one's own."""

    gradient_unit: GradientUnit = Field(description="unit of dT/dt in the data: K/min or K/s")
    grid: Grid
    surface: SurfaceName = Field(description="the surface that is learnt, unless a table is given")
    surfaces: Surfaces
    table: str | None = Field(
        default=None, description="CSV or Parquet file with the columns temperature_c, gradient, rate_c, learnt instead"
    )
    table_tolerance_c: float = Field(gt=0, description="by how much a printed rate may be rounded [C-rate]")


class FormSettings(Record):
    """The form of the network."""

    centres: int = Field(ge=1, description="rows of the data that become centres [1]")
    kernel: Kernel
    extension: float = Field(gt=1, description="support's radius over the nearest centre's distance [1]")
    widths: Widths


class SelectionSettings(Record):
    """How centres are selected."""

    genetic: GeneticSettings
    generations: int = Field(ge=1, description="generations behind the network that is used [1]")
    long_generations: int = Field(ge=1, description="generations that are followed in all [1]")
    replicates: int = Field(ge=1, description="selections, each with a random stream of its own [1]")
    methods: tuple[Method, ...] = Field(min_length=1, description="how centres are selected; genetic is used")

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.long_generations < self.generations:
            raise ValueError(f"long_generations is {self.long_generations}; allowed is {self.generations} or more")
        if len(set(self.methods)) < len(self.methods) or "genetic" not in self.methods:
            raise ValueError(f"methods is {list(self.methods)}; each may stand there once, and genetic must")
        return self


class NetworkStudy(Record):
    """The network of a charger: its data, its form, the selections of its centres, and what it is held against."""

    title: str = Field(min_length=1, description="name of the network, for people")
    data: DataSettings
    form: FormSettings
    selection: SelectionSettings
    anfis: AnfisSettings
    size: SizeStudy | None = None
    kernels: KernelStudy | None = None


class NetworkPart(Record):
    """The network that commands a charger."""

    network: NetworkStudy | None = Field(default=None, description="the network that commands a charger")


def _rising(name: str, values: tuple[float, ...]) -> None:
    if any(second <= first for first, second in itertools.pairwise(values)):
        raise ValueError(f"{name} is {list(values)}; each must lie above the one before")
