"""Weights that integrate `tau dv/dt = g - v` exactly for a forcing g quadratic in time.

The forcing is given by its values at the three nodes of Radau IIA (order 5; Hairer and Wanner, Solving Ordinary
Differential Equations II, table IV.5.6). With z = h / tau everything follows from phi_k(u) = sum u^m / (m + k)!.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import MOST_RELAXATIONS
from pipeline.jit import inlined, kernel

_ROOT = math.sqrt(6.0)
NODES = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
# Lagrange basis of the nodes in monomials, LAGRANGE[p, l]: coefficient of theta^p in the basis function of node l.
LAGRANGE = np.linalg.inv(np.vander(NODES, increasing=True))
# Integrals of the basis functions from 0 to each node: the matrix of Radau IIA; its last row are the weights.
RADAU = (NODES[:, None] ** np.arange(1, 4) / np.arange(1, 4)) @ LAGRANGE
# The same with the basis function first and a fourth moment, the start, where nothing has passed yet.
PASSED = np.hstack([RADAU.T, np.zeros((3, 1))])
# Basis functions extrapolated to the start of the step.
AT_START = LAGRANGE[0].copy()
_FACTORIAL = np.array([1.0, 1.0, 2.0])
_INVERSE_FACTORIAL = np.array([1.0 / math.factorial(k) for k in range(40)])
_SERIES_BELOW = 3.0
# Below this nothing is left: an exponential that small takes ten times as long.
_GONE = -700.0
PHI = 7
_FEWEST_TERMS, _MOST_TERMS = 4, 28


def _reach(terms: int) -> float:
    """Return the largest argument for which the series of `phi_functions` ends with so many terms."""
    low, high = 0.0, 4.0
    while True:
        u = 0.5 * (low + high)
        if u in (low, high):
            return low
        size = (u * u) * (u * u)
        for n in range(_FEWEST_TERMS + 2, terms + 2, 2):
            size *= u * u / (n * (n - 1.0))
        low, high = (u, high) if size <= 1e-17 else (low, u)


_REACH = np.array([_reach(terms) for terms in range(_FEWEST_TERMS, _MOST_TERMS, 2)])


MOST_SLOTS = 24
WEIGHT_FIELDS = [
    ("length_s", np.float64, (MOST_SLOTS,)),
    ("moments_s", np.float64, (MOST_SLOTS,)),
    ("decay", np.float64, (MOST_SLOTS, MOST_RELAXATIONS, 4)),
    ("node", np.float64, (MOST_SLOTS, MOST_RELAXATIONS, 3, 4)),
    ("start_moment", np.float64, (MOST_SLOTS, MOST_RELAXATIONS, 4)),
    ("moment", np.float64, (MOST_SLOTS, MOST_RELAXATIONS, 3, 4)),
    ("phi", np.float64, (8,)),
    ("monomial", np.float64, (3, 3)),
    ("row", np.float64, (3,)),
]
"""Fields of a record that holds the weights of several step lengths, a slot each.

The last index runs over the moments of a step, the three nodes and the start, or over the basis functions and a zero:
four numbers side by side.

length_s, moments_s : step length of a slot, and that which its moments are of, which only a step that counts needs.
decay[slot, k, j] : what is left of the starting value at moment j.
node[slot, k, l, j] : effect of the forcing at node l on the value at moment j.
start_moment[slot, k, l] : integral of the starting value's remains times basis function l, over the step [s].
moment[slot, k, m, l] : integral of the response to forcing m times basis function l, over the step [s].
"""


@kernel
def phi_functions(u: float, highest: int, out: NDArray[np.float64]) -> None:
    """Write phi_0 ... phi_highest of a non-positive argument.

    Small arguments: the series of the highest, then downwards; large ones: upwards from exp. Neither cancels.
    """
    if u > -_SERIES_BELOW:
        terms, size = 4, u**4
        while abs(size) > 1e-17 and terms < 28:
            terms += 2
            size *= u * u / (terms * (terms - 1.0))
        total = 0.0
        for m in range(terms, -1, -1):
            total = total * u + _INVERSE_FACTORIAL[m + highest]
        out[highest] = total
        for k in range(highest - 1, -1, -1):
            out[k] = _INVERSE_FACTORIAL[k] + u * out[k + 1]
    else:
        out[0] = math.exp(max(u, _GONE))
        for k in range(highest):
            out[k + 1] = (out[k] - _INVERSE_FACTORIAL[k]) / u


@kernel
def response(z: float, theta: float, phi: NDArray[np.float64], out: NDArray[np.float64]) -> float:
    """Write the values at theta of the responses to the three basis functions; return the decay of the start.

    A forcing theta^p gives z theta^(p+1) p! phi_(p+1)(-z theta).
    """
    phi_functions(-z * theta, 3, phi)
    for node in range(3):
        total, power = 0.0, z
        for p in range(3):
            power *= theta
            total += LAGRANGE[p, node] * power * _FACTORIAL[p] * phi[p + 1]
        out[node] = total
    return float(phi[0])


@inlined
def _put(row: NDArray[np.float64], a: float, b: float, c: float, d: float) -> None:
    row[0], row[1], row[2], row[3] = a, b, c, d


@inlined
def _terms_of(u: float) -> int:
    """Return after how many terms the series of `phi_functions` ends."""
    size, terms = abs(u), _FEWEST_TERMS
    for n in range(len(_REACH)):
        terms += 2 if size > _REACH[n] else 0
    return terms


@inlined
def _respond(weights: Any, slot: int, k: int, z: float) -> None:
    """Write decay and responses at the three nodes as `response` makes them, its series for all three side by side."""
    decay, node = weights.decay[slot, k], weights.node[slot, k]
    u0, u1, u2 = -z * NODES[0], -z * NODES[1], -z * NODES[2]
    n0, n1, n2 = _terms_of(u0), _terms_of(u1), _terms_of(u2)
    a = b = c = 0.0
    # The last node is the farthest from the start.
    for m in range(n2, -1, -1):
        one = _INVERSE_FACTORIAL[m + 3]
        a = a * u0 + one if m <= n0 else 0.0
        b = b * u1 + one if m <= n1 else 0.0
        c = c * u2 + one
    a2, b2, c2 = 0.5 + u0 * a, 0.5 + u1 * b, 0.5 + u2 * c
    a1, b1, c1 = 1.0 + u0 * a2, 1.0 + u1 * b2, 1.0 + u2 * c2
    _put(decay, 1.0 + u0 * a1, 1.0 + u1 * b1, 1.0 + u2 * c1, 1.0)
    p0, p1, p2 = z * NODES[0], z * NODES[1], z * NODES[2]
    q0, q1, q2 = p0 * NODES[0], p1 * NODES[1], p2 * NODES[2]
    r0, r1, r2 = q0 * NODES[0], q1 * NODES[1], q2 * NODES[2]
    for n in range(3):
        d, e, f = LAGRANGE[0, n], LAGRANGE[1, n], LAGRANGE[2, n]
        _put(
            node[n],
            d * p0 * a1 + e * q0 * a2 + f * r0 * 2.0 * a,
            d * p1 * b1 + e * q1 * b2 + f * r1 * 2.0 * b,
            d * p2 * c1 + e * q2 * c2 + f * r2 * 2.0 * c,
            0.0,
        )


@kernel
def fill(weights: Any, slot: int, length_s: float, tau_s: NDArray[np.float64], relaxations: int) -> None:
    """Compute the weights of one step length, moments left out, in a record with `WEIGHT_FIELDS`."""
    weights.length_s[slot], weights.moments_s[slot] = length_s, -1.0
    phi, row = weights.phi, weights.row
    for k in range(relaxations):
        z = length_s / tau_s[k]
        if z < _SERIES_BELOW:
            _respond(weights, slot, k, z)
            continue
        for j in range(3):
            weights.decay[slot, k, j] = response(z, NODES[j], phi, row)
            for node in range(3):
                weights.node[slot, k, node, j] = row[node]
        weights.decay[slot, k, 3] = 1.0


@kernel
def fill_moments(weights: Any, slot: int, tau_s: NDArray[np.float64], relaxations: int) -> None:
    """Compute the moments of a slot whose other weights are there."""
    length_s = weights.length_s[slot]
    weights.moments_s[slot] = length_s
    phi, monomial, row = weights.phi, weights.monomial, weights.row
    for k in range(relaxations):
        z = length_s / tau_s[k]
        phi_functions(-z, PHI - 1, phi)
        # Integrals of theta^q times the response to theta^p, and of theta^q exp(-z theta).
        for p in range(3):
            scale = z * _FACTORIAL[p] * length_s
            monomial[p, 0] = scale * phi[p + 2]
            monomial[p, 1] = scale * (phi[p + 2] - phi[p + 3])
            monomial[p, 2] = scale * (phi[p + 2] - 2.0 * phi[p + 3] + 2.0 * phi[p + 4])
        of_start = (phi[1], phi[1] - phi[2], phi[1] - 2.0 * phi[2] + 2.0 * phi[3])
        for node in range(3):
            weights.start_moment[slot, k, node] = length_s * (
                LAGRANGE[0, node] * of_start[0] + LAGRANGE[1, node] * of_start[1] + LAGRANGE[2, node] * of_start[2]
            )
            for p in range(3):
                row[p] = 0.0
                for q in range(3):
                    row[p] += LAGRANGE[q, node] * monomial[p, q]
            for other in range(3):
                weights.moment[slot, k, other, node] = (
                    LAGRANGE[0, other] * row[0] + LAGRANGE[1, other] * row[1] + LAGRANGE[2, other] * row[2]
                )
