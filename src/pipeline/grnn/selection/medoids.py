"""k-medoids: the rows in the middle of clusters, by alternation (Park, Jun 2009, DOI 10.1016/j.eswa.2008.01.039)."""

from __future__ import annotations

import numpy as np

from pipeline.grnn.records import Data
from pipeline.grnn.selection.problem import Array, Problem, Selected, Strings, once
from pipeline.search.streams import Generators

_MOST_ROUNDS = 100


def select(problem: Problem, random: Generators) -> Selected:
    """Return the medoids of one clustering per replicate, over the scaled inputs and the output together."""
    distance = _distances(problem.data)
    return once(problem, np.stack([medoids(distance, problem.centres, generator) for generator in random]))


def medoids(distance: Array, count: int, rng: np.random.Generator) -> Strings:
    """Return the rows that end as medoids, shape (n,), from a random start.

    Arguments
    ---------
    distance : between rows, shape (m, m).
    """
    rows = np.sort(rng.choice(len(distance), size=count, replace=False))
    for _ in range(_MOST_ROUNDS):
        cluster = np.argmin(distance[rows], axis=0)
        moved = rows.copy()
        for place in range(count):
            members = np.flatnonzero(cluster == place)
            if len(members):
                moved[place] = members[int(np.argmin(np.sum(distance[np.ix_(members, members)], axis=0)))]
        if np.array_equal(moved, rows):
            break
        rows = moved
    return rows


def _distances(data: Data) -> Array:
    output = data.rate / max(float(np.max(data.rate)), 1e-300)
    features = np.column_stack([data.inputs / data.scales, output])
    distance: Array = np.sqrt(np.sum((features[:, None] - features[None, :]) ** 2, axis=-1))
    return distance
