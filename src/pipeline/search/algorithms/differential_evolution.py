"""Differential evolution as scipy has it (Storn and Price, J. Global Optim. 11 (1997) 341), a population at once."""

from __future__ import annotations

from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pipeline.search.box import Box, History, Objective, Recorder, SearchSettings

Array = NDArray[np.float64]


class Settings(SearchSettings):
    """The settings; defaults are scipy's."""

    kind: Literal["differential_evolution"] = "differential_evolution"
    population: int = Field(ge=5, description="members of the population [1]")
    generations: int = Field(ge=1, description="generations, after the random start [1]")
    strategy: Literal["best1bin", "rand1bin", "randtobest1bin", "currenttobest1bin"] = "best1bin"
    mutation_low: float = Field(default=0.5, ge=0, lt=2, description="least factor of a difference [1]")
    mutation_high: float = Field(default=1.0, ge=0, lt=2, description="greatest factor of a difference [1]")
    recombination: float = Field(default=0.7, ge=0, le=1, description="chance that a coordinate is recombined [1]")


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator) -> History:
    """Run one search.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : of the search; its number of replicates does not count here.
    rng : where all its random numbers come from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    from scipy.optimize import Bounds, differential_evolution

    recorder = Recorder(objective)
    start = box.low + rng.random((settings.population, len(box.low))) * (box.high - box.low)

    def transposed(x: Array) -> Array:
        first = recorder.count == 0
        values = recorder(x.T)
        if first:
            recorder.mark()
        return values

    def ended(intermediate_result: Any) -> None:
        recorder.mark()

    # Vectorised, scipy hands over a population as columns; its type stubs know single points alone.
    differential_evolution(
        cast(Any, transposed), Bounds(box.low, box.high), strategy=settings.strategy, maxiter=settings.generations,
        mutation=(settings.mutation_low, settings.mutation_high), recombination=settings.recombination, init=start,
        tol=0.0, polish=False, updating="deferred", vectorized=True, rng=rng, callback=ended,
    )  # fmt: skip
    return recorder.history(settings.generations + 1)
