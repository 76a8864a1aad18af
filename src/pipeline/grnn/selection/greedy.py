"""Greedy selection: one centre after the other, each the best that can be added; then each exchanged for a better."""

from __future__ import annotations

import numpy as np

from pipeline.grnn.selection.problem import Array, Problem, Selected, Strings
from pipeline.search.streams import Generators


def select(problem: Problem, random: Generators) -> Selected:
    """Return the one selection; nothing is random.

    The exchange takes the centres in turn and tries every row in each one's place, until no exchange helps or the
    evaluations are used up; the first pass over all sizes is always whole.
    """
    rows, error = forward(problem)
    points, used = len(problem.data.rate), problem.centres * len(problem.data.rate)
    place, unchanged = 0, 0
    while unchanged < problem.centres and used + points <= problem.evaluations:
        candidates = np.tile(rows, (points, 1))
        candidates[:, place] = np.arange(points)
        found = problem.errors(candidates)
        used += points
        best, unchanged = int(np.argmin(found)), unchanged + 1
        if found[best] < error[-1]:
            rows, unchanged = candidates[best], 0
            error[-1] = found[best]
        place = (place + 1) % problem.centres
    return Selected(rows[None, :], error[-1:], used)


def forward(problem: Problem) -> tuple[Strings, Array]:
    """Return the rows in the order they were added, and the error with one, two, ... of them, shape (n,) each."""
    points = len(problem.data.rate)
    rows, error = np.empty(0, dtype=np.int64), np.empty(problem.centres)
    for count in range(problem.centres):
        candidates = np.column_stack([np.tile(rows, (points, 1)), np.arange(points)])
        found = problem.errors(candidates)
        rows, error[count] = candidates[int(np.argmin(found))], float(np.min(found))
    return rows, error
