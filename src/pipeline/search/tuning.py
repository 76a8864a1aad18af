"""What a swarm achieves with given W, C1 and C2: the results that a parameter design asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.search.algorithms.swarm import Knobs, Settings, knobs, run
from pipeline.search.box import History, Objective
from pipeline.search.streams import generators

Array = NDArray[np.float64]
Statistic = Literal["cumulative", "final"]

_TOGETHER = 1000  # searches advanced at once; bounds the memory that their random numbers take


def statistic(history: History, kind: Statistic) -> Array:
    """Return one number per replicate: the best value summed over the moves, or the best at the end."""
    return history.value[:, 1:].sum(axis=1) if kind == "cumulative" else history.best_value()


def results(
    objective: Objective,
    settings: Settings,
    factors: Mapping[str, Array],
    replicates: int,
    kind: Statistic,
    seed: int,
) -> Array:
    """Run the swarm with every combination of its knobs.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    settings : everything but the knobs that `factors` names.
    factors : `w`, `c1`, `c2` or some of them -> a value per combination, shape (m,).
    replicates : searches per combination.
    kind : what a search counts for.
    seed : root of the random streams; search j of combination i draws from SeedSequence([seed, i * replicates + j]).

    Returns
    -------
    Shape (m, replicates).

    Raises
    ------
    ValueError : a factor is no knob of the swarm.
    """
    unknown = sorted(set(factors) - set(Knobs._fields))
    if unknown:
        raise ValueError(f"factors are {unknown}; the swarm's knobs are {list(Knobs._fields)}")
    spread = {name: np.repeat(np.asarray(values, dtype=float), replicates) for name, values in factors.items()}
    count = len(next(iter(spread.values())))
    fixed = knobs(settings.model_copy(update=dict.fromkeys(factors, 0.0)))
    found = []
    for first in range(0, count, _TOGETHER):
        part = {name: values[first : first + _TOGETHER] for name, values in spread.items()}
        random = generators(seed, first, min(_TOGETHER, count - first))
        history = run(objective, settings.box(), settings, fixed._replace(**part), random)
        found.append(statistic(history, kind))
    return np.concatenate(found).reshape(-1, replicates)
