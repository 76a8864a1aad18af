"""Cuckoo search as the paper's control loop: its characteristic equation, and the same loop in steps.

With a nest X, a reference that stands still and e = reference - X, the reconstructed move
X(t+1) = w X(t) + Kp e(t) + Ki (sum of e) less X(t) is taken as dX/dt = (w - 1) X + Kp e + Ki (integral of e), which has

    open loop (Kp s + Ki) / (s (s + 1 - w)),    characteristic equation s^2 + (1 - w + Kp) s + Ki = 0.

The analysis holds for a constant Kp. In the search Kp is random with mean 0, the best nest moves, and a move that makes
matters worse is not taken: the equation tells how the loop tends to go, not whether the search converges.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]


def poles(w: float, kp: float, ki: float) -> Complex:
    """Return both roots of s^2 + (1 - w + Kp) s + Ki = 0, per generation; without the integral the one of the loop."""
    return np.roots([1.0, 1.0 - w + kp, ki] if ki > 0.0 else [1.0, 1.0 - w + kp]).astype(complex)


def is_stable(w: float, kp: float, ki: float) -> bool:
    """Tell whether the loop comes to rest: all coefficients positive (Routh)."""
    return 1.0 - w + kp > 0.0 and ki >= 0.0


def is_ringing(w: float, kp: float, ki: float) -> bool:
    """Tell whether the loop comes to rest in dying oscillations: stable, and the roots a complex pair."""
    return is_stable(w, kp, ki) and (1.0 - w + kp) ** 2 < 4.0 * ki


def steady_state_error(w: float, kp: float, ki: float) -> float:
    """Return the error that stays after a unit step of the reference; NaN where the loop does not come to rest.

    Without the integral it is (1 - w) / (1 - w + Kp): plain search, w = 1, has none, since its X is a sum already.
    """
    if not is_stable(w, kp, ki):
        return np.nan
    return 0.0 if ki > 0.0 else (1.0 - w) / (1.0 - w + kp)


def step_poles(w: float, kp: float, ki: float, leak: float) -> Complex:
    """Return the factors by which the loop shrinks from one generation to the next, as the search takes it.

    The leaky sum is S(t) = leak S(t-1) + e(t), used in the move of the same generation. The loop comes to rest where
    all factors lie within the unit circle, which the continuous equation does not ask for.
    """
    if ki == 0.0:
        return np.array([w - kp], dtype=complex)
    # With the reference at 0: S' = leak S - X and X' = (w - Kp) X + Ki S'.
    loop = np.array([[w - kp - ki, ki * leak], [-1.0, leak]])
    return np.linalg.eigvals(loop).astype(complex)
