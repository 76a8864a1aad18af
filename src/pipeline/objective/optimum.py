"""The best frequency from the condition that the loss is stationary, how flat it is, and what moves it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.loss import frequency_loss_w
from pipeline.objective.records import Pairs
from pipeline.objective.ripple import Steps, pair_slope_j

Array = NDArray[np.float64]

_BISECTIONS = 50  # of nine decades: 2e-14 of the frequency


class Band(NamedTuple):
    """The frequencies [Hz] between which an objective stays within a share of its minimum."""

    low_hz: float
    high_hz: float


def optimal_frequency_hz(
    period: Steps, pairs: Pairs, energy_j: ArrayLike, low_hz: float = 1e-3, high_hz: float = 1e6
) -> Array:
    """Return the frequency of least loss for each switching energy.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    energy_j : switching energies of a period [J], any shape, above 0.
    low_hz, high_hz : where to look [Hz].

    Returns
    -------
    Frequency [Hz], same shape; the loss falls and then rises, so it is the only one. NaN where it lies outside.
    """
    energy = np.asarray(energy_j, dtype=float)
    return _bisected(lambda frequency: pair_slope_j(period, pairs, frequency) + energy, energy.shape, low_hz, high_hz)


def energy_for_optimum_j(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the switching energy [J] with which each frequency [Hz] would be the best: the contours of the map."""
    return -pair_slope_j(period, pairs, frequency_hz)


def band_hz(period: Steps, pairs: Pairs, energy_j: float, share: float) -> Band:
    """Return the band around the optimum in which the ISE exceeds its minimum by at most a share.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    energy_j : switching energy of a period [J].
    share : allowed excess over the minimum [1].

    Returns
    -------
    Both ends [Hz]; the window of the integral cancels.
    """
    best = float(optimal_frequency_hz(period, pairs, energy_j))
    limit = np.sqrt(1.0 + share) * frequency_loss_w(period, pairs, energy_j, best)

    def over(frequency: Array) -> Array:
        excess: Array = frequency_loss_w(period, pairs, energy_j, frequency) - limit
        return excess

    low = _bisected(lambda frequency: -over(frequency), (), 1e-6 * best, best)
    high = _bisected(over, (), best, 1e6 * best)
    return Band(float(low), float(high))


def frequency_map_hz(period: Steps, pairs: Pairs, pair: int, capacitance_f: Array, energy_j: Array) -> Array:
    """Return the best frequency over one pair's capacitance and the switching energy.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    pair : index of the pair whose capacitance varies, its resistance kept.
    capacitance_f : capacitances [F], shape (m,).
    energy_j : switching energies of a period [J], shape (n,).

    Returns
    -------
    Frequency [Hz], shape (m, n).
    """
    rows = [optimal_frequency_hz(period, with_capacitance(pairs, pair, value), energy_j) for value in capacitance_f]
    return np.stack(rows)


def contour_energy_j(period: Steps, pairs: Pairs, pair: int, capacitance_f: Array, frequency_hz: float) -> Array:
    """Return, for each capacitance [F], the switching energy [J] that puts the optimum at a frequency: one contour."""
    found = [
        energy_for_optimum_j(period, with_capacitance(pairs, pair, value), frequency_hz) for value in capacitance_f
    ]
    return np.array(found, dtype=float)


def with_capacitance(pairs: Pairs, pair: int, capacitance_f: float) -> Pairs:
    """Return the pairs with another capacitance [F] of one of them."""
    constants = list(pairs.time_constant_s)
    constants[pair] = pairs.resistance_ohm[pair] * float(capacitance_f)
    return pairs._replace(time_constant_s=tuple(constants))


def _bisected(rising: Callable[[Array], Array], shape: tuple[int, ...], low_hz: float, high_hz: float) -> Array:
    """Return where a function that rises through zero does so, all entries together, on a logarithmic axis."""
    low, high = np.full(shape, np.log(low_hz)), np.full(shape, np.log(high_hz))
    inside = (rising(np.exp(low)) <= 0.0) & (rising(np.exp(high)) >= 0.0)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        above = rising(np.exp(middle)) > 0.0
        high = np.where(above, middle, high)
        low = np.where(above, low, middle)
    found: Array = np.where(inside, np.exp(0.5 * (low + high)), np.nan)
    return found
