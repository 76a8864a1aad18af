"""Selections to compare with that do not search: random rows, the best of many random strings, a regular grid."""

from __future__ import annotations

import math

import numpy as np

from pipeline.grnn.selection.problem import Array, Problem, Selected, Strings, once
from pipeline.search.streams import Generators


def random_rows(problem: Problem, random: Generators) -> Selected:
    """Return one set of distinct rows per replicate, as drawn: what a network costs that nobody selected for."""
    points = len(problem.data.rate)
    drawn = [generator.choice(points, size=problem.centres, replace=False) for generator in random]
    return once(problem, np.stack(drawn))


def best_of_random(problem: Problem, random: Generators) -> Selected:
    """Return the best of as many random strings as the genetic algorithm evaluates, for each replicate."""
    rows, error = [], []
    for generator in random:
        drawn = generator.integers(len(problem.data.rate), size=(problem.evaluations, problem.centres))
        found = problem.errors(drawn)
        rows.append(drawn[int(np.argmin(found))])
        error.append(float(np.min(found)))
    return Selected(np.stack(rows), np.array(error), problem.evaluations)


def regular_grid(problem: Problem, random: Generators) -> Selected:
    """Return the rows nearest to the middles of n equal rectangles; nothing is random."""
    return once(problem, regular(problem.data.inputs, problem.centres)[None, :])


def regular(inputs: Array, count: int) -> Strings:
    """Return rows nearest to the middles of equal rectangles, no fewer along the first input than along the second.

    Arguments
    ---------
    inputs : shape (m, 2).
    """
    along = min(first for first in range(math.isqrt(count - 1) + 1, count + 1) if count % first == 0)
    low, span = np.min(inputs, axis=0), np.ptp(inputs, axis=0)
    share = [(np.arange(number) + 0.5) / number for number in (along, count // along)]
    middles = np.stack(np.meshgrid(*share, indexing="ij"), axis=-1).reshape(-1, 2)
    scaled = (inputs - low) / np.where(span > 0.0, span, 1.0)
    rows: Strings = np.argmin(np.sum((scaled[None, :] - middles[:, None]) ** 2, axis=-1), axis=1)
    return rows
