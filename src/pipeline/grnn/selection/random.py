"""Rows drawn at random, each set taken as it comes: what a network costs that nobody selected for."""

from __future__ import annotations

import numpy as np

from pipeline.grnn.selection.problem import Problem, Selected, once
from pipeline.search.streams import Generators


def select(problem: Problem, random: Generators) -> Selected:
    """Return one set of distinct rows per replicate."""
    points = len(problem.data.rate)
    drawn = [generator.choice(points, size=problem.centres, replace=False) for generator in random]
    return once(problem, np.stack(drawn))
