"""Mean square error of networks whose centres are rows of the data, many of them at once (paper eq. 2)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.grnn.network import EXTENDABLE, GAUSSIAN, KERNELS, TIE, Network, make_network, weight
from pipeline.grnn.records import Data, Kernel
from pipeline.jit import jit, kernel

Array = NDArray[np.float64]
Strings = NDArray[np.int64]

# A sum of Gaussian weights below this is taken again, relative to the nearest centre's.
_THIN = 1e-280


class Form(NamedTuple):
    """What every network of a comparison has in common: kernel, extension, and widths over the scaled inputs [1]."""

    kernel: Kernel
    widths: tuple[float, float]
    extension: float = 2.0


class Candidates(NamedTuple):
    """Every row of the data as a centre, for one form: what errors need and no choice of centres changes."""

    kernel: int
    extension: float
    distance: Array
    """Distances between rows, in widths, shape (m, m)."""
    weights: Array
    """Weights at these distances, shape (m, m); empty where they depend on the other centres."""
    wanted: Array
    """The data's output, shape (m,) [C-rate]."""


def candidates(data: Data, form: Form) -> Candidates:
    """Return the rows of the data as centres."""
    scaled = data.inputs / data.scales / np.array(form.widths)
    distance = np.sqrt(np.sum((scaled[:, None] - scaled[None, :]) ** 2, axis=-1))
    code = KERNELS.index(form.kernel)
    weights = np.empty((0, 0)) if code == EXTENDABLE else _weights(code, distance)
    return Candidates(code, form.extension, distance, weights, data.rate)


def network_of(data: Data, form: Form, rows: NDArray[np.int64]) -> Network:
    """Return the network with these rows of the data as its centres, shape (n,)."""
    return make_network(
        data.inputs[rows],
        data.rate[rows],
        widths=form.widths,
        scales=data.scales,
        kernel=form.kernel,
        extension=form.extension,
        low=data.inputs.min(axis=0),
        high=data.inputs.max(axis=0),
        gradient_seconds=data.gradient_seconds,
    )


@jit
def _weights(code: int, distance: Array) -> Array:
    found = np.empty_like(distance)
    for row in range(len(distance)):
        for column in range(len(distance)):
            found[row, column] = weight(code, distance[row, column] ** 2, 0.0, 1.0)
    return found


@jit
def errors(table: Candidates, strings: Strings) -> Array:
    """Return the mean square error [C-rate^2] of each network, shape (s,), over all rows of the data.

    Arguments
    ---------
    strings : rows of the data that are a network's centres, shape (s, n).
    """
    found = np.empty(len(strings))
    rows = len(table.wanted)
    weighted, total, nearest = np.empty(rows), np.empty(rows), np.empty(rows)
    for index in range(len(strings)):
        string = strings[index]
        if table.kernel == EXTENDABLE:
            _extended(table, string, weighted, total, nearest)
        else:
            _fixed(table, string, weighted, total, nearest)
        for row in range(rows):
            miss = weighted[row] / total[row] - table.wanted[row]
            weighted[row] = miss * miss
        found[index] = _sum(weighted) / rows
    return found


@kernel
def _sum(values: Array) -> float:
    """Return a sum, taken in four strands: one alone would wait for each of its additions."""
    first, second, third, fourth = 0.0, 0.0, 0.0, 0.0
    whole = len(values) - len(values) % 4
    for row in range(0, whole, 4):
        first += values[row]
        second += values[row + 1]
        third += values[row + 2]
        fourth += values[row + 3]
    for row in range(whole, len(values)):
        first += values[row]
    return (first + second) + (third + fourth)


@kernel
def _fixed(table: Candidates, string: Strings, weighted: Array, total: Array, nearest: Array) -> None:
    """Sum weighted outputs and weights of every row under a kernel that knows no other centre."""
    weighted[:] = 0.0
    total[:] = 0.0
    for centre in string:
        output, weights = table.wanted[centre], table.weights[centre]
        for row in range(len(total)):
            weighted[row] += weights[row] * output
            total[row] += weights[row]
    least = math.inf
    for row in range(len(total)):
        least = total[row] if total[row] < least else least
    if least < _THIN:
        _nearest(table, string, nearest)
        if table.kernel == GAUSSIAN:
            for row in range(len(total)):
                if total[row] < _THIN:
                    _shifted(table, string, row, weighted, total, nearest[row])
        else:
            _by_nearest(table, string, weighted, total, nearest)


@kernel
def _nearest(table: Candidates, string: Strings, nearest: Array) -> None:
    """Find the distance of the nearest centre of every row."""
    nearest[:] = np.inf
    for centre in string:
        distance = table.distance[centre]
        for row in range(len(nearest)):
            nearest[row] = distance[row] if distance[row] < nearest[row] else nearest[row]


@kernel
def _shifted(table: Candidates, string: Strings, row: int, weighted: Array, total: Array, nearest: float) -> None:
    """Sum one row's Gaussian weights relative to that of the nearest centre."""
    weighted[row], total[row] = 0.0, 0.0
    for centre in string:
        share = math.exp(-0.5 * (table.distance[centre, row] ** 2 - nearest**2))
        weighted[row] += share * table.wanted[centre]
        total[row] += share


@kernel
def _by_nearest(table: Candidates, string: Strings, weighted: Array, total: Array, nearest: Array) -> None:
    """Give every row that no support reaches to its nearest centres."""
    for row in range(len(total)):
        thin = total[row] < _THIN
        # No distance lies below a negative one: the other rows stay as they are.
        nearest[row] = TIE * nearest[row] ** 2 if thin else -1.0
        weighted[row] = 0.0 if thin else weighted[row]
        total[row] = 0.0 if thin else total[row]
    for centre in string:
        output, distance = table.wanted[centre], table.distance[centre]
        for row in range(len(total)):
            share = 1.0 if distance[row] * distance[row] <= nearest[row] else 0.0
            weighted[row] += share * output
            total[row] += share


@kernel
def _extended(table: Candidates, string: Strings, weighted: Array, total: Array, nearest: Array) -> None:
    """Sum weighted outputs and weights of every row under supports that reach it."""
    weighted[:] = 0.0
    total[:] = 0.0
    _nearest(table, string, nearest)
    for row in range(len(total)):
        radius = table.extension * nearest[row]
        nearest[row] = 1.0 / (radius if radius > 1.0 else 1.0)
    for centre in string:
        output, distance = table.wanted[centre], table.distance[centre]
        for row in range(len(total)):
            share = distance[row] * nearest[row]
            rest = 1.0 - share if share < 1.0 else 0.0
            rest *= rest
            rest *= rest * (4.0 * share + 1.0)
            weighted[row] += rest * output
            total[row] += rest
