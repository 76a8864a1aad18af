import math

import numpy as np
import pytest
from scipy.integrate import quad

from pipeline.cell.relaxation import LAGRANGE, NODES, RADAU, fill, fill_moments, response
from pipeline.charge.state import new_run

RATIOS = [1e-7, 1e-3, 0.3, 2.99, 3.01, 30.0, 1e5]


def weights(z, length=2.0):
    run = new_run()
    tau = np.full(8, length / z)
    fill(run, 0, length, tau, 1)
    fill_moments(run, 0, tau, 1)
    return run


def basis(node, theta):
    return sum(LAGRANGE[p, node] * theta**p for p in range(3))


def test_the_nodes_are_those_of_radau_iia():
    root = math.sqrt(6)
    assert RADAU[2] == pytest.approx([(16 - root) / 36, (16 + root) / 36, 1 / 9], rel=1e-14)
    assert RADAU[0, 0] == pytest.approx((88 - 7 * root) / 360, rel=1e-14)
    assert NODES[2] == 1.0


@pytest.mark.parametrize("z", RATIOS)
def test_a_constant_forcing_relaxes_by_the_exponential(z):
    run = weights(z)
    for j in range(3):
        assert run["decay"][0, 0, j] == pytest.approx(math.exp(-z * NODES[j]), rel=1e-14, abs=1e-300)
        assert run["node"][0, 0, :, j].sum() == pytest.approx(-math.expm1(-z * NODES[j]), rel=1e-13)


@pytest.mark.parametrize("z", [0.3, 2.99, 3.01, 30.0])
def test_node_weights_are_the_convolution_of_the_basis(z):
    run = weights(z)
    for j in range(3):
        for node in range(3):
            expected, _ = quad(
                lambda t, j=j, node=node: z * math.exp(-z * (NODES[j] - t)) * basis(node, t), 0, NODES[j], epsabs=1e-14
            )
            assert run["node"][0, 0, node, j] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("z", RATIOS)
def test_moments_obey_the_equation_they_integrate(z):
    """Summed over the basis, tau (v_end - v_start) = int g - int v, for the start's remains and for each forcing."""
    length = 2.0
    run = weights(z, length)
    tau = length / z
    left = run["start_moment"][0, 0].sum()
    assert tau * (1.0 - run["decay"][0, 0, 2]) == pytest.approx(left, rel=1e-10 if z > 1e-4 else 1e-8)
    for forcing in range(3):
        taken = length * RADAU[2, forcing] - run["moment"][0, 0, forcing].sum()
        assert tau * run["node"][0, 0, forcing, 2] == pytest.approx(taken, rel=1e-9, abs=1e-9 * length)


@pytest.mark.parametrize("z", [0.3, 3.01, 30.0])
def test_each_moment_is_the_integral_of_response_times_basis(z):
    run = weights(z, 1.0)

    def response(forcing, theta):
        return quad(lambda t: z * math.exp(-z * (theta - t)) * basis(forcing, t), 0, theta, epsabs=1e-13)[0]

    for node in range(3):
        start, _ = quad(lambda t, node=node: math.exp(-z * t) * basis(node, t), 0, 1, epsabs=1e-13)
        assert run["start_moment"][0, 0, node] == pytest.approx(start, abs=1e-12)
        expected, _ = quad(lambda t, node=node: response(1, t) * basis(node, t), 0, 1, epsabs=1e-11)
        assert run["moment"][0, 0, 1, node] == pytest.approx(expected, abs=1e-10)


def test_responses_side_by_side_are_those_one_by_one_to_the_last_bit():
    random = np.random.default_rng(3)
    for z in (*RATIOS, 0.0, *10.0 ** random.uniform(-9.0, 1.0, 300)):
        run, row, phi = weights(z) if z else new_run(), np.empty(3), np.empty(8)
        if not z:
            fill(run, 0, 0.0, np.ones(8), 1)
        exact = run["length_s"][0] / (2.0 / z) if z else 0.0
        for j, theta in enumerate(NODES):
            assert run["decay"][0, 0, j] == response(exact, theta, phi, row)
            assert run["node"][0, 0, :, j].tolist() == row.tolist()
