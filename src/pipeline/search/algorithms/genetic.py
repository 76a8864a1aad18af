"""Genetic algorithm as pymoo has it: simulated binary crossover, polynomial mutation, elitist survival."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import Field

from pipeline.search.box import Box, History, Objective, SearchSettings, drive


class Settings(SearchSettings):
    """The settings; all others are pymoo's defaults."""

    kind: Literal["genetic"] = "genetic"
    population: int = Field(ge=3, description="members of the population [1]")
    generations: int = Field(ge=1, description="generations, after the random start [1]")


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator) -> History:
    """Run one search.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : of the search; its number of replicates does not count here.
    rng : where the seed of its random numbers comes from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """

    def make() -> Any:
        from pymoo.algorithms.soo.nonconvex.ga import GA

        return GA(pop_size=settings.population)

    return drive(make, objective, box, settings.generations, rng)
