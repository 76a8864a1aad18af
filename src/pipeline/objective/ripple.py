"""The loss of a periodic current in RC pairs, in closed form.

In a pair R || C the resistor's current y follows tau dy/dt = i - y. Times y, and averaged over a period in the steady
state, that gives mean(y^2) = mean(i y): the loss R mean(y^2) needs only the integral of y over each part, which an
exponential gives exactly. No harmonic is left out. The share of the ripple that a pair passes depends on frequency
times time constant alone.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.records import Pairs
from pipeline.objective.waveform import Steps, mean_current_a

Array = NDArray[np.float64]
Values = TypeVar("Values", bound=NDArray[Any])

_COMPLEX_STEP = 1e-30


def passed_square_a2(period: Steps, cycles: Values) -> Values:
    """Return the mean square of the ripple current through a pair's resistor.

    Arguments
    ---------
    period : the current.
    cycles : frequency times time constant [1], any shape, above 0; complex values pass through.

    Returns
    -------
    Mean square [A^2], same shape: the ripple's own as `cycles` goes to 0, falling with its inverse square at the end.
    Rounding grows with that square, to 1e-8 of the result at 1e3 cycles, where a pair passes nearly nothing.
    """
    ripple = np.asarray(period.current_a) - mean_current_a(period)
    lengths = [share / cycles for share in period.share]  # of each part, in time constants
    risen = [-np.expm1(-length) for length in lengths]
    # The state where the period begins, from the condition that it ends there too.
    gained, left = risen[-1] * ripple[-1], 1.0 - risen[-1]
    for current, rise in zip(ripple[-2::-1], risen[-2::-1], strict=True):
        gained = gained + left * rise * current
        left = left * (1.0 - rise)
    state = gained / -np.expm1(-1.0 / cycles)
    total = np.zeros_like(cycles)
    for current, length, rise in zip(ripple, lengths, risen, strict=True):
        total += current * (current * length - (current - state) * rise)
        state = state + (current - state) * rise
    result: Values = total * cycles
    return result


def pair_loss_w(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the loss of the ripple in all pairs together.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    frequency_hz : frequencies of the period [Hz], any shape, above 0.

    Returns
    -------
    Loss beside that of the mean current [W], same shape.
    """
    frequency = np.asarray(frequency_hz, dtype=float)
    loss = np.zeros(frequency.shape)
    for resistance, time_constant in zip(*pairs, strict=True):
        loss += resistance * passed_square_a2(period, frequency * time_constant)
    return loss


def pair_slope_j(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the derivative of `pair_loss_w` by frequency [W/Hz = J], exact to rounding.

    The closed form is analytic, so its imaginary part after an imaginary step is the derivative without a difference
    (Squire and Trapp, SIAM Rev. 40 (1998) 110, DOI 10.1137/S003614459631241X).
    """
    frequency = np.asarray(frequency_hz, dtype=float)
    slope = np.zeros(frequency.shape)
    for resistance, time_constant in zip(*pairs, strict=True):
        cycles = frequency * time_constant
        moved = passed_square_a2(period, cycles + 1j * _COMPLEX_STEP)
        slope += resistance * time_constant * moved.imag / _COMPLEX_STEP
    return slope
