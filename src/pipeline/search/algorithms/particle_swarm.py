"""Particle swarm as pymoo has it: its constants adapt as the swarm spreads.

Zhan, Zhang, Li and Chung, IEEE Trans. Syst. Man Cybern. B 39 (2009) 1362, DOI 10.1109/TSMCB.2009.2015956.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import Field

from pipeline.search.box import Box, History, Objective, SearchSettings, drive


class Settings(SearchSettings):
    """The settings; all others are pymoo's defaults."""

    kind: Literal["particle_swarm"] = "particle_swarm"
    population: int = Field(ge=3, description="particles of the swarm [1]")
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
        from pymoo.algorithms.soo.nonconvex.pso import PSO

        return PSO(pop_size=settings.population)

    return drive(make, objective, box, settings.generations, rng)
