"""The best of as many random strings as the genetic algorithm evaluates."""

from __future__ import annotations

import numpy as np

from pipeline.grnn.selection.problem import Problem, Selected
from pipeline.search.streams import Generators


def select(problem: Problem, random: Generators) -> Selected:
    """Return the best string of each replicate."""
    rows, error = [], []
    for generator in random:
        drawn = generator.integers(len(problem.data.rate), size=(problem.evaluations, problem.centres))
        found = problem.errors(drawn)
        rows.append(drawn[int(np.argmin(found))])
        error.append(float(np.min(found)))
    return Selected(np.stack(rows), np.array(error), problem.evaluations)
