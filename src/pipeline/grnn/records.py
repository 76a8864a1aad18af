"""Names of kernels and of ways to select centres, the widths that are tried, and how the neuro-fuzzy peer learns."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from pipeline.record import Record

Kernel = Literal["gaussian", "wendland", "extendable"]
Positive = Annotated[float, Field(gt=0)]
Method = Literal["genetic", "exchange", "random_best", "greedy", "least_squares", "medoids", "random", "regular"]


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

    temperature_sets: int = Field(ge=2, le=64, description="membership functions over temperature [1]")
    gradient_sets: int = Field(ge=2, le=64, description="membership functions over the gradient [1]")
    epochs: int = Field(ge=1, description="passes over the data [1]")
    step: float = Field(gt=0, description="first length of a step along the gradient [1]")


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
