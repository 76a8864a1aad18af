"""The control loop of the paper's section 3.4 against its equation solved in time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.experiments.functions.functions import is_ringing, is_stable, poles, steady_state_error, step_poles

CASES = list(itertools.product([1.0, 0.6], [0.05, 0.5, 2.0], [0.0, 0.01, 0.2, 1.5]))


def response(w, kp, ki, end=4000.0):
    """Return time and error after a unit step of the reference: dX/dt = (w - 1) X + Kp e + Ki (integral of e)."""

    def slope(t, y):
        error = 1.0 - y[0]
        return [(w - 1.0) * y[0] + kp * error + ki * y[1], error]

    solved = solve_ivp(slope, (0.0, end), [0.0, 0.0], method="LSODA", rtol=1e-8, atol=1e-10, dense_output=True)
    time = np.linspace(0.0, end, 20_001)
    return time, 1.0 - solved.sol(time)[0]


@pytest.mark.parametrize(("w", "kp", "ki"), CASES)
def test_error_that_stays_is_that_of_the_loop_in_time(w, kp, ki):
    _, error = response(w, kp, ki)
    assert error[-1] == pytest.approx(steady_state_error(w, kp, ki), abs=1e-6)


@pytest.mark.parametrize(("w", "kp", "ki"), [case for case in CASES if case[2] > 0.0])
def test_ringing_is_seen_in_time(w, kp, ki):
    _, error = response(w, kp, ki, end=200.0)
    # A decaying oscillation crosses 0 again and again; the zero of the loop alone makes it cross once.
    crossings = np.count_nonzero(np.diff(np.sign(error[np.abs(error) > 1e-8])))
    assert (crossings > 1) == is_ringing(w, kp, ki)


def test_roots_solve_the_characteristic_equation():
    for w, kp, ki in CASES:
        found = poles(w, kp, ki)
        assert len(found) == (2 if ki > 0.0 else 1)
        np.testing.assert_allclose(found**2 + (1 - w + kp) * found + ki, 0.0, atol=1e-12)
        assert is_stable(w, kp, ki) == bool(np.all(found.real < 0.0))
        assert is_ringing(w, kp, ki) == bool(np.all(found.real < 0.0) and np.any(found.imag != 0.0))


def test_the_boundaries():
    assert not is_ringing(1.0, 0.2, 0.01), "equal roots do not ring"
    assert is_ringing(1.0, 0.2, 0.0101)
    assert not is_stable(1.0, -0.1, 0.05)
    assert is_stable(1.0, 0.05, 0.0)
    assert not is_stable(1.0, 0.0, 0.05), "undamped"
    assert np.isnan(steady_state_error(1.0, -0.1, 0.05))
    assert np.isnan(steady_state_error(1.0, -0.1, 0.0))


def test_plain_search_has_no_error_to_remove():
    assert steady_state_error(1.0, 0.3, 0.0) == 0.0
    assert steady_state_error(0.9, 0.3, 0.0) == pytest.approx(0.25)
    assert steady_state_error(0.9, 0.3, 0.05) == 0.0


@pytest.mark.parametrize(
    ("w", "kp", "ki", "leak"), [(1.0, 0.3, 0.05, 0.9), (0.9, 0.2, 0.0, 0.9), (0.8, 0.1, 0.4, 1.0), (1.0, 0.5, 3.5, 1.0)]
)
def test_factors_of_a_step_are_those_of_the_loop_run(w, kp, ki, leak):
    x, total, sizes = 1.0, 0.0, []
    for _ in range(400):
        error = -x
        total = leak * total + error
        x = w * x + kp * error + ki * total
        sizes.append(np.hypot(x, ki * total))
    grows = np.abs(step_poles(w, kp, ki, leak)).max()
    measured = (sizes[-1] / sizes[100]) ** (1.0 / 299)
    assert measured == pytest.approx(grows, rel=0.02)


def test_the_equation_in_time_allows_what_steps_do_not():
    assert is_stable(1.0, 0.5, 3.5)
    assert np.abs(step_poles(1.0, 0.5, 3.5, 1.0)).max() > 1.0
