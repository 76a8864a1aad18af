"""The data a network learns from: charging rates over temperature and its gradient."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
