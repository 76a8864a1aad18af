"""The moves of cuckoo search as kernels; `algorithms/cuckoo.py` says what they are and where from.

`fly`, `walk` and `keep` move the nests of one replicate. `advance` runs whole generations with them and calls a
compiled objective itself; for any other objective `fly_all`, `walk_all` and `keep_all` take all replicates one move on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import jit, kernel
from pipeline.search.compiled import Kernel
from pipeline.search.levy import Draws

Array = NDArray[np.float64]


class Law(NamedTuple):
    """What rules the moves: the settings that are numbers, and the box."""

    pa: float
    step_scale: float
    ki: float
    leak: float
    low: Array
    """Shape (d,)."""
    high: Array
    """Shape (d,)."""


class Nests(NamedTuple):
    """The nests, for r replicates of n nests in d dimensions; every move writes to them."""

    position: Array
    """Shape (r, n, d)."""
    value: Array
    """Shape (r, n)."""
    integral: Array
    """Leaky sum of the distances to the best nest, shape (r, n, d)."""
    leader: NDArray[np.int64]
    """Best nest of each replicate, shape (r,)."""

    def of(self, replicates: slice) -> Nests:
        """Return the nests of some replicates, the same in memory."""
        return Nests(
            self.position[replicates], self.value[replicates], self.integral[replicates], self.leader[replicates]
        )


class Course(NamedTuple):
    """The best nest of each replicate, row by row, t rows."""

    position: Array
    """Shape (r, t, d)."""
    value: Array
    """Shape (r, t)."""


@kernel
def fly(
    position: Array, leader: int, integral: Array, levy: Array, weight: float, law: Law, candidate: Array
) -> None:  # fmt: skip
    """Write where the Levy flights lead, within the box, and the new integral; arrays of shape (n, d)."""
    for n in range(position.shape[0]):
        for d in range(position.shape[1]):
            error = position[leader, d] - position[n, d]
            summed = law.leak * integral[n, d] + error
            free = weight * position[n, d] - law.step_scale * levy[n, d] * error + law.ki * summed
            integral[n, d] = summed
            candidate[n, d] = min(max(free, law.low[d]), law.high[d])


@kernel
def walk(
    position: Array, partners: NDArray[np.int64], length: Array, chance: Array, law: Law, candidate: Array
) -> None:  # fmt: skip
    """Write where the biased walks lead, X + length H(pa - chance) (X_j - X_k), within the box, shape (n, d)."""
    for n in range(position.shape[0]):
        first, second = partners[0, n], partners[1, n]
        for d in range(position.shape[1]):
            away = length[n] * (position[first, d] - position[second, d])
            free = position[n, d] + (away if chance[n, d] < law.pa else 0.0)
            candidate[n, d] = min(max(free, law.low[d]), law.high[d])


@kernel
def keep(position: Array, value: Array, candidate: Array, found: Array) -> int:
    """Move each nest to its candidate (n, d) where what was found there (n,) is no worse; return the best nest."""
    leader = 0
    for n in range(position.shape[0]):
        if found[n] <= value[n]:
            value[n] = found[n]
            for d in range(position.shape[1]):
                position[n, d] = candidate[n, d]
        if value[n] < value[leader]:
            leader = n
    return leader


@jit
def advance(
    objective: Kernel, numbers: Array, law: Law, weights: Array, drawn: Draws, nests: Nests, course: Course, row: int
) -> None:  # fmt: skip
    """Run generations with an objective's kernel, replicate after replicate.

    Arguments
    ---------
    objective, numbers : the kernel, and what it takes beside the positions.
    weights : the inertia w of each generation [1].
    drawn : the random numbers of at least as many generations.
    course : is written, from `row` on.
    """
    replicates, count, dimensions = nests.position.shape
    candidate, found = np.empty((count, dimensions)), np.empty(count)
    for r in range(replicates):
        position, value, leader = nests.position[r], nests.value[r], nests.leader[r]
        for g in range(len(weights)):
            fly(position, leader, nests.integral[r], drawn.levy[r, g], weights[g], law, candidate)
            objective(numbers, candidate, found)
            leader = keep(position, value, candidate, found)
            walk(position, drawn.partners[r, g], drawn.length[r, g], drawn.chance[r, g], law, candidate)
            objective(numbers, candidate, found)
            leader = keep(position, value, candidate, found)
            course.value[r, row + g] = value[leader]
            for d in range(dimensions):
                course.position[r, row + g, d] = position[leader, d]
        nests.leader[r] = leader


@jit
def fly_all(law: Law, weight: float, drawn: Draws, g: int, nests: Nests, candidate: Array) -> None:
    """Write where the flights of generation g of a block lead, shape (r, n, d)."""
    for r in range(len(candidate)):
        fly(nests.position[r], nests.leader[r], nests.integral[r], drawn.levy[r, g], weight, law, candidate[r])


@jit
def walk_all(law: Law, drawn: Draws, g: int, nests: Nests, candidate: Array) -> None:
    """Write where the walks of generation g of a block lead, shape (r, n, d)."""
    for r in range(len(candidate)):
        position, partners = nests.position[r], drawn.partners[r, g]
        walk(position, partners, drawn.length[r, g], drawn.chance[r, g], law, candidate[r])


@jit
def keep_all(nests: Nests, candidate: Array, found: Array) -> None:
    """Move the nests of all replicates to what was found (r, n) at their candidates (r, n, d) where it is no worse."""
    for r in range(len(candidate)):
        nests.leader[r] = keep(nests.position[r], nests.value[r], candidate[r], found[r])
