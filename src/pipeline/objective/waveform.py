"""A periodic, piecewise-constant current as two short arrays, and its moments."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.objective.records import Waveform

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
