"""The error e(t) of equation (5), its integral square, and the objective a search minimises.

The paper defines e(t) in words alone and integrates to infinity, where a steady error gives no number. Here e is the
loss that no frequency could avoid, the series resistance's under the ripple, less the loss there is. The series
resistance cancels in the difference. The period is in its steady state, so e is constant and the window a factor.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.loss import frequency_loss_w, switching_energy_j
from pipeline.objective.records import Pairs, Problem
from pipeline.objective.waveform import Steps, steps, switched_currents_a

Array = NDArray[np.float64]
MILLIWATT_PER_WATT = 1e3


def error_mw(period: Steps, pairs: Pairs, energy_j: float, frequency_hz: ArrayLike) -> Array:
    """Return e [mW], the loss at infinite frequency without switching less the loss there is; never positive."""
    return -MILLIWATT_PER_WATT * frequency_loss_w(period, pairs, energy_j, frequency_hz)


def integral_square_error(error: ArrayLike, window_s: float) -> Array:
    """Return the integral of a constant error's square over the window [mW^2 s] (eq. 5)."""
    return np.asarray(error, dtype=float) ** 2 * window_s


def objective(period: Steps, pairs: Pairs, energy_j: float, window_s: float) -> Callable[[Array], Array]:
    """Return the function a search minimises: positions (n, 1), the frequency [Hz], to ISE (n,) [mW^2 s]."""

    def evaluate(position: Array) -> Array:
        return integral_square_error(error_mw(period, pairs, energy_j, position[:, 0]), window_s)

    return evaluate


def objective_of(problem: Problem) -> Callable[[Array], Array]:
    """Return the function a search minimises, from its record."""
    energy = switching_energy_j(problem.transistor, switched_currents_a(problem.waveform))
    return objective(steps(problem.waveform), problem.pairs, energy, problem.window_s)
