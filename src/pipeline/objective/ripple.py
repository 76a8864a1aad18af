"""The loss of a periodic current in RC pairs, in closed form.

In a pair R || C the resistor's current y follows tau dy/dt = i - y. Times y, and averaged over a period in the steady
state, that gives mean(y^2) = mean(i y): the loss R mean(y^2) needs only the integral of y over each part, which an
exponential gives exactly. No harmonic is left out. The share of the ripple that a pair passes depends on frequency
times time constant alone.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.records import Pairs, Waveform

Array = NDArray[np.float64]


class Steps(NamedTuple):
    """One period: the currents [A] and the shares of the period [1] they last, in order; the shares sum to 1."""

    current_a: tuple[float, ...]
    share: tuple[float, ...]


def steps(waveform: Waveform) -> Steps:
    """Return the parts of one period that have a length: charge, discharge, rest."""
    rest = 1.0 - waveform.charge_share - waveform.discharge_share
    parts = (
        (waveform.charge_a, waveform.charge_share),
        (-waveform.discharge_a, waveform.discharge_share),
        (0.0, rest),
    )
    kept = [(current, share) for current, share in parts if share > 1e-12]
    return Steps(tuple(current for current, _ in kept), tuple(share for _, share in kept))


def mean_current_a(period: Steps) -> float:
    """Return the mean current [A]."""
    return float(np.dot(period.current_a, period.share))


def ripple_square_a2(period: Steps) -> float:
    """Return the mean square of the current less its mean [A^2]: the sum of 2 |c_n|^2 over all harmonics."""
    ripple = np.asarray(period.current_a) - mean_current_a(period)
    return float(np.dot(ripple**2, period.share))


def switched_currents_a(waveform: Waveform) -> tuple[float, ...]:
    """Return the current [A] that each switch in use turns on and off once in a period."""
    switched: list[float] = []
    if waveform.charge_share < 1.0:
        switched.append(waveform.charge_a)
    if waveform.discharge_a > 0.0 and waveform.discharge_share > 0.0:
        switched.append(waveform.discharge_a)
    return tuple(switched)


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


def impedance_ohm(
    frequency_hz: float, inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float
) -> complex:
    """Return the impedance [ohm] of inductance, series resistance and one pair at a frequency [Hz]."""
    omega = 2.0 * math.pi * frequency_hz
    return 1j * omega * inductance_h + series_ohm + pair_ohm / (1.0 + 1j * omega * pair_ohm * pair_f)


def impedance_minimum_hz(inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency of least |Z|.

    Arguments
    ---------
    inductance_h : inductance of battery and leads [H].
    series_ohm : series resistance R_0 [ohm].
    pair_ohm, pair_f : charge-transfer resistance R [ohm] and double-layer capacitance C [F].

    Returns
    -------
    Frequency [Hz] from d|Z|^2/dw = 0; 0 where |Z| rises from direct current on.
    """
    time_constant = pair_ohm * pair_f
    root = math.sqrt(
        2.0 * inductance_h * pair_ohm**2 * pair_f + pair_ohm**3 * pair_f**2 * (2.0 * series_ohm + pair_ohm)
    )
    square = (root / inductance_h - 1.0) / time_constant**2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)


def resonance_hz(inductance_h: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency [Hz] at which Z is real, 1/(L C) - 1/(R C)^2 = w^2; 0 where there is none."""
    square = 1.0 / (inductance_h * pair_f) - 1.0 / (pair_ohm * pair_f) ** 2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)
