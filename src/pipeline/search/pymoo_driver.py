"""Runs a single-objective algorithm of pymoo (Blank and Deb, IEEE Access 8 (2020) 89497) on one of our objectives.

pymoo takes long to import, so it is imported when a search runs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.search.box import Box
from pipeline.search.history import History, Objective, Recorder


def drive(
    make: Callable[[], Any], objective: Objective, box: Box, generations: int, rng: np.random.Generator
) -> History:
    """Run one search.

    Arguments
    ---------
    make : returns the algorithm.
    objective : positions (n, d) to values (n,).
    box : where to look.
    generations : how many, after the start.
    rng : where the seed of its random numbers comes from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    from pymoo.core.problem import Problem

    recorder = Recorder(objective)

    class Boxed(Problem):  # type: ignore[misc]
        def _evaluate(self, x: Any, out: Any, *args: Any, **kwargs: Any) -> None:
            out["F"] = recorder(x)

    problem = Boxed(n_var=len(box.low), n_obj=1, xl=box.low, xu=box.high)
    algorithm = make()
    algorithm.setup(problem, termination=("n_gen", generations + 1), seed=int(rng.integers(2**31)), verbose=False)
    while algorithm.has_next():
        algorithm.next()
        recorder.mark()
    return recorder.history(generations + 1)
