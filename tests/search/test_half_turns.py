"""The sine in half turns against libm."""

from __future__ import annotations

import numpy as np

from pipeline.jit import jit
from pipeline.search.moves import sine, sine_squared


@jit
def both(x):
    return np.array([sine(one) for one in x]), np.array([sine_squared(one) for one in x])


def test_it_is_the_sine():
    angles = np.linspace(-0.5, 0.5, 20_001)
    found, squared = both(angles)
    np.testing.assert_allclose(found, np.sin(np.pi * angles), rtol=1e-15, atol=2.3e-16)
    np.testing.assert_allclose(squared, np.sin(np.pi * angles) ** 2, rtol=2e-15)


def test_its_square_is_periodic():
    near = np.linspace(-0.5, 0.5, 101)[1:-1]
    for turns in (-7.0, 1.0, 1e6):
        moved = near + turns
        np.testing.assert_array_equal(both(moved)[1], both(moved - turns)[1])
