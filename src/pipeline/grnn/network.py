"""The generalised regression neural network as arrays, and its response (Specht 1991, DOI 10.1109/72.97934).

The paper's eq. (1): C(x) = sum_i y_i phi(|x - x_i|) / sum_i phi(|x - x_i|), over scaled inputs. Never 0/0: the Gaussian
keeps the nearest centre's weight at 1, the extendable support reaches every query, and where no Wendland support
reaches, the nearest centre's output stands (the mean of several's), to which the ratio tends at the edge of a support.

    make_network(centres, outputs, *, widths, scales, kernel="gaussian", extension=2.0, low, high, gradient_seconds)
        -> Network                                     a picklable NamedTuple of arrays
    predict(network, temperature_c, gradient) -> C-rate        numba, for use inside a kernel; inputs as in the data
    command(network, temperature_c, rate_k_s) -> C-rate        the same from dT/dt in K/s, held within the data's range
    predict_many(network, temperature_c, gradient) -> C-rates  arrays of one shape
    network_fields(most), write_network(bank, network)         the network inside a structured record of a kernel

`predict` and `command` take a Network or any record with `network_fields`, in Python and in kernels alike.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import best_matches
from pipeline.grnn.records import Kernel
from pipeline.jit import inlined, jit

KERNELS: tuple[Kernel, ...] = ("gaussian", "wendland", "extendable")
GAUSSIAN, WENDLAND, EXTENDABLE = range(3)
"""Codes of the kernels: their places in `KERNELS`."""
EDGE = 1.0 - 1e-9
"""Where a support ends; on a grid centres lie at its edge, where rounding must not decide which of them counts."""


@inlined
def weight(kernel: int, squared: float, nearest: float, extension: float) -> float:
    """Return the weight of a centre at a query.

    Gaussian: exp(-d^2/2), with the nearest centre's d^2 taken off, which cancels in the network's ratio and keeps one
    weight at 1 however far the query is. Wendland: (1 - d)^4 (4 d + 1) for d < 1, else 0 (Adv. Comput. Math. 4 (1995)
    389, DOI 10.1007/BF02123482). Extendable: Wendland's function on a support of radius max(1, extension x distance of
    the nearest centre), so that every query lies in one; the paper names such a function and gives no formula, so this
    one is ours.

    Arguments
    ---------
    kernel : its code.
    squared : squared distance from the centre, in widths [1].
    nearest : that of the nearest centre.
    extension : support's radius over the nearest centre's distance, above 1; counts for the extendable kernel alone.
    """
    if kernel == GAUSSIAN:
        return math.exp(-0.5 * (squared - nearest))
    radius = 1.0
    if kernel == EXTENDABLE:
        radius = max(1.0, extension * math.sqrt(nearest))
    distance = math.sqrt(squared) / radius
    if distance >= EDGE:
        return 0.0
    rest = (1.0 - distance) * (1.0 - distance)
    return rest * rest * (4.0 * distance + 1.0)


Array = NDArray[np.float64]

# Beyond this many widths distances count as equal: their squares stay finite.
_FAR = 1e75
TIE = 1.0 + 1e-9
"""Squared distances within this factor of the least are those of the nearest centres; on a grid many are."""


class Network(NamedTuple):
    """A network of n centres over d inputs; for the charger d is 2: temperature and its gradient."""

    kernel: int
    """Code of the kernel, `kernels.KERNELS[kernel]` is its name."""
    centre_count: int
    centres: Array
    """Centres, shape (n, d) [degC, unit of dT/dt]."""
    outputs: Array
    """Output of each centre, shape (n,) [C-rate]."""
    scales: Array
    """What each input is divided by, shape (d,) [degC, unit of dT/dt]."""
    widths: Array
    """Width of the kernel along each scaled input, shape (d,) [1]."""
    extension: float
    """Radius of an extended support over the distance of the nearest centre [1]."""
    low: Array
    """Lower end of the data, shape (d,) [degC, unit of dT/dt]; `command` holds its inputs at or above."""
    high: Array
    """Upper end of the data, shape (d,)."""
    gradient_seconds: float
    """Seconds in the unit of dT/dt: 60 for K/min, 1 for K/s."""


def make_network(
    centres: ArrayLike,
    outputs: ArrayLike,
    *,
    widths: ArrayLike,
    scales: ArrayLike = 1.0,
    kernel: Kernel = "gaussian",
    extension: float = 2.0,
    low: ArrayLike = -math.inf,
    high: ArrayLike = math.inf,
    gradient_seconds: float = 60.0,
) -> Network:
    """Return a network.

    Arguments
    ---------
    centres : shape (n, d) [degC, unit of dT/dt].
    outputs : shape (n,) [C-rate].
    widths : width of the kernel along each scaled input, a number or (d,) [1].
    scales : what each input is divided by, a number or (d,).
    kernel : its name.
    extension : support's radius over the distance of the nearest centre, above 1; for the extendable kernel.
    low, high : ends of the data, within which `command` holds its inputs; numbers or (d,).
    gradient_seconds : seconds in the unit of dT/dt; 60: K/min.

    Raises
    ------
    ValueError : an argument of another shape or out of its range.
    """
    points, values = np.array(centres, dtype=float, order="C"), np.array(outputs, dtype=float)
    if points.ndim != 2 or values.shape != points.shape[:1] or 0 in points.shape:
        raise ValueError(f"centres {points.shape} and outputs {values.shape}; allowed are (n, d) and (n,), n, d >= 1")
    if not (np.all(np.isfinite(points)) and np.all(np.isfinite(values))):
        raise ValueError("centres and outputs must be finite")
    if kernel not in KERNELS:
        raise ValueError(f"kernel is {kernel!r}; {best_matches(str(kernel), KERNELS)}")
    if not (math.isfinite(extension) and extension > 1.0):
        raise ValueError(f"extension is {extension}; it must be finite and above 1")
    if not (math.isfinite(gradient_seconds) and gradient_seconds > 0.0):
        raise ValueError(f"gradient_seconds is {gradient_seconds}; it must be finite and above 0")
    return Network(
        KERNELS.index(kernel),
        len(points),
        points,
        values,
        _positive("scales", scales, points.shape[1]),
        _positive("widths", widths, points.shape[1]),
        float(extension),
        np.array(np.broadcast_to(np.asarray(low, dtype=float), points.shape[1:])),
        np.array(np.broadcast_to(np.asarray(high, dtype=float), points.shape[1:])),
        float(gradient_seconds),
    )


def _positive(name: str, values: ArrayLike, inputs: int) -> Array:
    found = np.array(np.broadcast_to(np.asarray(values, dtype=float), (inputs,)))
    if not np.all(np.isfinite(found) & (found > 0.0)):
        raise ValueError(f"{name} is {found.tolist()}; each must be finite and above 0")
    return found


@inlined
def _squared_distance(network: Any, row: int, query: Any) -> float:
    """Return the squared distance of a query from a centre, in widths."""
    total = 0.0
    for k in range(len(query)):
        distance = (query[k] - network.centres[row, k]) / network.scales[k] / network.widths[k]
        distance = min(abs(distance), _FAR)
        total += distance * distance
    return total


@inlined
def respond(network: Any, query: Any) -> float:
    """Return the network's output at a query of any number of inputs, an array or a tuple."""
    nearest = math.inf
    for row in range(network.centre_count):
        nearest = min(nearest, _squared_distance(network, row, query))
    weighted, total = 0.0, 0.0
    for row in range(network.centre_count):
        share = weight(network.kernel, _squared_distance(network, row, query), nearest, network.extension)
        weighted += share * network.outputs[row]
        total += share
    if total == 0.0:
        for row in range(network.centre_count):
            share = 1.0 if _squared_distance(network, row, query) <= TIE * nearest else 0.0
            weighted += share * network.outputs[row]
            total += share
    return weighted / total


@inlined
def predict(network: Any, temperature_c: float, gradient: float) -> float:
    """Return the charging rate [C-rate] at a temperature [degC] and a gradient [the data's unit of dT/dt]."""
    return respond(network, (float(temperature_c), float(gradient)))


@inlined
def command(network: Any, temperature_c: float, rate_k_s: float) -> float:
    """Return the charging rate [C-rate] at a temperature [degC] that changes by so much [K/s].

    The one place where dT/dt is converted. Outside the data's range the network has learnt nothing, so each input is
    held at its end.
    """
    temperature = min(max(temperature_c, network.low[0]), network.high[0])
    gradient = min(max(rate_k_s * network.gradient_seconds, network.low[1]), network.high[1])
    return respond(network, (float(temperature), float(gradient)))


def predict_many(network: Network, temperature_c: ArrayLike, gradient: ArrayLike) -> Array:
    """Return the charging rates [C-rate] at temperatures [degC] and gradients [the data's unit], of one shape."""
    temperature, rate = np.broadcast_arrays(np.asarray(temperature_c, dtype=float), np.asarray(gradient, dtype=float))
    queries = np.stack([temperature.ravel(), rate.ravel()], axis=1)
    return responses(network, queries).reshape(temperature.shape)


@jit
def responses(network: Network, queries: Array) -> Array:
    """Return the network's output at queries, shape (m, d), as (m,)."""
    found = np.empty(len(queries))
    for row in range(len(queries)):
        found[row] = respond(network, queries[row])
    return found


def network_fields(most: int) -> list[Any]:
    """Return the fields of a structured record that holds a network of two inputs and at most so many centres."""
    return [
        ("kernel", np.int64),
        ("centre_count", np.int64),
        ("centres", np.float64, (most, 2)),
        ("outputs", np.float64, (most,)),
        ("scales", np.float64, (2,)),
        ("widths", np.float64, (2,)),
        ("extension", np.float64),
        ("low", np.float64, (2,)),
        ("high", np.float64, (2,)),
        ("gradient_seconds", np.float64),
    ]


def write_network(bank: Any, network: Network) -> None:
    """Write a network into a record with `network_fields`; raise ValueError where its centres do not fit."""
    most = len(bank["outputs"])
    if network.centre_count > most:
        raise ValueError(f"a network of {network.centre_count} centres; this kernel takes {most}")
    for name, value in network._asdict().items():
        if name in ("centres", "outputs"):
            bank[name][: network.centre_count] = value
        else:
            bank[name] = value
