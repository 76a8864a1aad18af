"""Orthogonal least squares (Chen, Cowan, Grant, IEEE Trans. Neural Netw. 2 (1991) 302, DOI 10.1109/72.80341).

It selects the centres of a radial basis function network with linear output weights and a constant, by the share of the
output's energy that each regressor explains beyond those before it. Here its centres serve the regression network.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.grnn.error import candidates
from pipeline.grnn.selection.problem import Array, Problem, Selected, once
from pipeline.search.streams import Generators

# A regressor with less than this share of its energy left is a sum of those chosen.
_DEPENDENT = 1e-10


class Orthogonal(NamedTuple):
    """Rows in the order they were chosen, shape (n,), and the mean square error left after each, shape (n,)."""

    rows: NDArray[np.int64]
    error: Array


def select(problem: Problem, random: Generators) -> Selected:
    """Return the one selection; nothing is random."""
    return once(problem, least_squares(problem).rows[None, :])


def least_squares(problem: Problem) -> Orthogonal:
    """Select regressors by forward orthogonalisation; a support that extends is taken at its least, radius 1."""
    form = problem.form
    fixed = problem.table if len(problem.table.weights) else candidates(problem.data, form._replace(kernel="wendland"))
    return orthogonal(fixed.weights.T, problem.data.rate, problem.centres)


def orthogonal(regressors: Array, wanted: Array, count: int) -> Orthogonal:
    """Choose columns of `regressors`, shape (m, k), that explain `wanted`, shape (m,), one after the other.

    The constant is there from the start. Where every column left is a sum of those chosen, the first are taken.
    """
    energy = np.sum(regressors**2, axis=0)
    left, rest = regressors - np.mean(regressors, axis=0), wanted - np.mean(wanted)
    rows, error = np.empty(count, dtype=np.int64), np.empty(count)
    free = np.ones(left.shape[1], dtype=np.bool_)
    for place in range(count):
        norm = np.sum(left**2, axis=0)
        usable = free & (norm > _DEPENDENT * energy)
        gain = np.where(usable, (rest @ left) ** 2 / np.where(usable, norm, 1.0), np.where(free, -1.0, -2.0))
        best = int(np.argmax(gain))
        if usable[best]:
            direction = left[:, best] / np.sqrt(norm[best])
            rest = rest - direction * (direction @ rest)
            left -= np.outer(direction, direction @ left)
        free[best] = False
        rows[place], error[place] = best, float(np.mean(rest**2))
    return Orthogonal(rows, error)
