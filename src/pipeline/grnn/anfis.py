"""The adaptive neuro-fuzzy inference system with hybrid learning (Jang 1993, DOI 10.1109/21.256541), for two inputs.

First-order Takagi-Sugeno rules over every pair of generalised bells 1 / (1 + |(x - c)/a|^(2 b)); each epoch fits the
rules' planes by least squares, then moves the bells down the gradient of the error.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.grnn.records import AnfisSettings, Data

Array = NDArray[np.float64]

INPUTS = 2
# Jang's heuristic: after so many falls in a row the step grows, after so many ups and downs it shrinks.
_FALLS, _GROWTH, _TURNS, _SHRINKAGE = 4, 1.1, 4, 0.9
_NARROWEST = 1e-3


class Anfis(NamedTuple):
    """A trained system over inputs scaled to [0, 1]."""

    bells: tuple[Array, Array]
    """Half width a, slope b, centre c of the bells over each input, shape (sets, 3)."""
    planes: Array
    """Two slopes and a constant of each rule, shape (rules, 3); the second input's sets run fastest."""
    scales: Array
    """What the inputs are divided by, shape (2,)."""


class Learning(NamedTuple):
    """The system of least error, and the mean square error [C-rate^2] after each epoch's least squares."""

    system: Anfis
    error: Array


def nodes(sets: tuple[int, int]) -> int:
    """Return the number of nodes as MATLAB's `anfis` counts them: 27 for three and two sets, which are six rules."""
    return INPUTS + 2 * sum(sets) + 2 * sets[0] * sets[1] + 3


def learn(data: Data, settings: AnfisSettings) -> Learning:
    """Train a system on the data, from bells evenly spaced over it."""
    inputs, sets = data.inputs / data.scales, (settings.temperature_sets, settings.gradient_sets)
    bells = _even(inputs[:, 0], sets[0]), _even(inputs[:, 1], sets[1])
    history, step, best = np.empty(settings.epochs), settings.step, None
    for epoch in range(settings.epochs):
        planes = fit_planes(bells, inputs, data.rate)
        system = Anfis(bells, planes, data.scales)
        history[epoch], slopes = error_and_slopes(system, inputs, data.rate)
        if best is None or history[epoch] < np.min(history[:epoch]):
            best = system
        length = np.sqrt(sum(float(np.sum(slope**2)) for slope in slopes))
        if length == 0.0:
            history[epoch:] = history[epoch]
            break
        bells = _moved(bells, slopes, step / length)
        step = _adapted(step, history[: epoch + 1])
    assert best is not None
    return Learning(best, history)


def predict(system: Anfis, inputs: Array) -> Array:
    """Return the rates [C-rate] at inputs, shape (m, 2) [degC, unit of dT/dt]."""
    scaled = inputs / system.scales
    shares = _shares(system.bells, scaled)[0]
    rates: Array = np.sum(shares * (_extended(scaled) @ system.planes.T), axis=1)
    return rates


def fit_planes(bells: tuple[Array, Array], inputs: Array, wanted: Array) -> Array:
    """Return the planes of least squared error for given bells, shape (rules, 3)."""
    shares = _shares(bells, inputs)[0]
    columns = (shares[:, :, None] * _extended(inputs)[:, None, :]).reshape(len(inputs), -1)
    found = np.linalg.lstsq(columns, wanted, rcond=1e-10)[0].reshape(-1, INPUTS + 1)
    return np.asarray(found, dtype=float)


def error_and_slopes(system: Anfis, inputs: Array, wanted: Array) -> tuple[float, tuple[Array, Array]]:
    """Return the mean square error over scaled inputs and its derivatives by the bells' parameters.

    Arguments
    ---------
    inputs, wanted : shapes (m, 2) and (m,).

    Returns
    -------
    The error [C-rate^2] and its slopes, shapes as of `system.bells`.
    """
    shares, strength, memberships = _shares(system.bells, inputs)
    heights = _extended(inputs) @ system.planes.T
    output = np.sum(shares * heights, axis=1)
    miss = output - wanted
    # d output / d strength of a rule, then by each membership that the rule multiplies.
    by_strength = (heights - output[:, None]) / np.sum(strength, axis=1)[:, None]
    table = (2.0 * miss / len(wanted))[:, None, None] * by_strength.reshape(len(wanted), *map(len, system.bells))
    by_first = np.einsum("mij,jm->im", table, memberships[1])
    by_second = np.einsum("mij,im->jm", table, memberships[0])
    slopes = (
        np.einsum("im,ipm->ip", by_first, _bell_slopes(system.bells[0], inputs[:, 0], memberships[0])),
        np.einsum("jm,jpm->jp", by_second, _bell_slopes(system.bells[1], inputs[:, 1], memberships[1])),
    )
    return float(np.mean(miss**2)), slopes


def _even(values: Array, sets: int) -> Array:
    """Return bells that cross at 0.5, evenly spaced over the values."""
    low, high = float(np.min(values)), float(np.max(values))
    half = max(0.5 * (high - low) / (sets - 1), _NARROWEST)
    return np.column_stack([np.full(sets, half), np.full(sets, 2.0), np.linspace(low, high, sets)])


def _extended(inputs: Array) -> Array:
    return np.column_stack([inputs, np.ones(len(inputs))])


def _memberships(bells: Array, values: Array) -> Array:
    half, slope, centre = (column[:, None] for column in bells.T)
    found: Array = 1.0 / (1.0 + (((values[None, :] - centre) / half) ** 2) ** slope)
    return found


def _shares(bells: tuple[Array, Array], inputs: Array) -> tuple[Array, Array, tuple[Array, Array]]:
    """Return each rule's share and strength, shape (m, rules), and the memberships, shape (sets, m) each."""
    memberships = _memberships(bells[0], inputs[:, 0]), _memberships(bells[1], inputs[:, 1])
    strength = np.einsum("im,jm->mij", *memberships).reshape(len(inputs), -1)
    return strength / np.sum(strength, axis=1, keepdims=True), strength, memberships


def _bell_slopes(bells: Array, values: Array, membership: Array) -> Array:
    """Return the derivatives of bells by half width, slope and centre, shape (sets, 3, m)."""
    half, slope, centre = (column[:, None] for column in bells.T)
    offset = values[None, :] - centre
    steepness = membership * (1.0 - membership)
    apart = offset != 0.0
    logarithm = np.log(np.where(apart, (offset / half) ** 2, 1.0))
    by_centre = 2.0 * slope * steepness / np.where(apart, offset, 1.0) * apart
    return np.stack([2.0 * slope / half * steepness, -logarithm * steepness, by_centre], axis=1)


def _moved(bells: tuple[Array, Array], slopes: tuple[Array, Array], length: float) -> tuple[Array, Array]:
    moved = []
    for bell, slope in zip(bells, slopes, strict=True):
        new = bell - length * slope
        new[:, :2] = np.maximum(new[:, :2], _NARROWEST)
        moved.append(new)
    return moved[0], moved[1]


def _adapted(step: float, history: Array) -> float:
    change = np.sign(np.diff(history[-_FALLS - 1 :]))
    if len(change) < _FALLS:
        return step
    if np.all(change < 0):
        return step * _GROWTH
    turns = np.sign(np.diff(history[-_TURNS - 1 :]))
    if np.array_equal(turns[0::2], np.ones(2)) and np.array_equal(turns[1::2], -np.ones(2)):
        return step * _SHRINKAGE
    return step
