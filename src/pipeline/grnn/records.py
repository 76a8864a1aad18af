"""What a study gives to learn a charger's network from, how it is chosen, and what it is held against."""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from pipeline.record import Record
from pipeline.search.genetic import GeneticSettings

Kernel = Literal["gaussian", "wendland", "extendable"]
GradientUnit = Literal["k_min", "k_s"]
Positive = Annotated[float, Field(gt=0)]
SurfaceName = Literal["plateau_steps", "plateau_ramp", "sigmoid", "takagi_sugeno"]
LONG = "genetic_long"
"""Name of the network that the genetic algorithm ends with beyond the generations that are used."""
Method = Literal["genetic", "exchange", "random_best", "greedy", "least_squares", "medoids", "random", "regular"]


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


class Widths(Record):
    """Every pair of these widths is tried with each method, the best once more for longer; the best is taken."""

    temperature: tuple[Positive, ...] = Field(min_length=1, description="over the scaled temperature [1]")
    gradient: tuple[Positive, ...] = Field(min_length=1, description="over the scaled gradient [1]")
    trial_replicates: int = Field(ge=1, description="selections that a pair is judged by [1]")
    trial_generations: int = Field(ge=1, description="generations whose evaluations each of them has [1]")
    finalists: int = Field(ge=1, description="best pairs that are tried again with all evaluations [1]")

    def pairs(self) -> list[tuple[float, float]]:
        """Return all pairs."""
        return [(first, second) for first in self.temperature for second in self.gradient]


class AnfisSettings(Record):
    """The adaptive neuro-fuzzy network and its hybrid learning (Jang 1993)."""

    temperature_sets: int = Field(ge=2, description="membership functions over temperature [1]")
    gradient_sets: int = Field(ge=2, description="membership functions over the gradient [1]")
    epochs: int = Field(ge=1, description="passes over the data [1]")
    step: float = Field(gt=0, description="first length of a step along the gradient [1]")


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


def _rising(name: str, values: tuple[float, ...]) -> None:
    if any(second <= first for first, second in itertools.pairwise(values)):
        raise ValueError(f"{name} is {list(values)}; each must lie above the one before")


Array = NDArray[np.float64]

LEAST_POINTS = 2


class Data(NamedTuple):
    """Points with their rate; the inputs are divided by `scales` wherever a distance is taken."""

    inputs: Array
    """Temperature and gradient, shape (m, 2) [degC, unit of dT/dt]."""
    rate: Array
    """Charging rate, shape (m,) [C-rate]."""
    scales: Array
    """Largest magnitude of each input, shape (2,); 1 where an input is zero throughout."""
    gradient_seconds: float
    """Seconds in the unit of dT/dt."""


def data_of(temperature_c: ArrayLike, gradient: ArrayLike, rate: ArrayLike, gradient_seconds: float) -> Data:
    """Return points as data.

    Arguments
    ---------
    temperature_c, gradient, rate : shape (m,) each [degC, unit of dT/dt, C-rate].
    gradient_seconds : seconds in the unit of dT/dt.

    Raises
    ------
    ValueError : too few points, a value that is not finite, a negative rate, or two points at one place.
    """
    columns = {"temperature_c": temperature_c, "gradient": gradient, "rate_c": rate}
    arrays = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    sizes = {name: values.shape for name, values in arrays.items()}
    if len(set(sizes.values())) != 1 or arrays["rate_c"].ndim != 1:
        raise ValueError(f"columns of shapes {sizes}; allowed is one length for all")
    if len(arrays["rate_c"]) < LEAST_POINTS:
        raise ValueError(f"{len(arrays['rate_c'])} points; allowed are {LEAST_POINTS} or more")
    for name, values in arrays.items():
        _refuse(~np.isfinite(values), name, values, "each must be a finite number")
    _refuse(arrays["rate_c"] < 0.0, "rate_c", arrays["rate_c"], "a charging rate is 0 or more")
    inputs = np.stack([arrays["temperature_c"], arrays["gradient"]], axis=1)
    _, place, times = np.unique(inputs, axis=0, return_index=True, return_counts=True)
    if np.any(times > 1):
        row = int(place[np.argmax(times > 1)])
        raise ValueError(f"row {row + 1}: {inputs[row].tolist()} stands there more than once; each point may once")
    largest = np.max(np.abs(inputs), axis=0)
    return Data(inputs, arrays["rate_c"], np.where(largest > 0.0, largest, 1.0), float(gradient_seconds))


def _refuse(wrong: NDArray[np.bool_], name: str, values: Any, allowed: str) -> None:
    if np.any(wrong):
        row = int(np.argmax(wrong))
        raise ValueError(f"row {row + 1}: {name} is {values[row]:g}; {allowed}")
