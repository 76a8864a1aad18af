"""Brute force: an even grid over the box, then finer grids around its best point; the oracle of the other searches."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pipeline.search.box import Box, History, Objective, SearchSettings, joined

Array = NDArray[np.float64]

_MOST_POINTS = 10_000_000


class Settings(SearchSettings):
    """The grid."""

    kind: Literal["sweep"] = "sweep"
    points: int = Field(ge=5, description="points of the grid along each variable")
    refinements: int = Field(default=0, ge=0, description="finer grids, each over two spacings around the best point")

    @model_validator(mode="after")
    def _feasible(self) -> Settings:
        total = self.points ** len(self.variables)
        if total > _MOST_POINTS:
            raise ValueError(
                f"points is {self.points} along each of {len(self.variables)} variables, {total} in all; "
                f"allowed are {_MOST_POINTS}"
            )
        return self


def grid(box: Box, points: int) -> Array:
    """Return all points of an even grid over the box, both ends included, shape (points^d, d)."""
    axes = [np.linspace(low, high, points) for low, high in zip(box.low, box.high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator | None = None) -> History:
    """Search the grid and its refinements; nothing is random.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : the grid.
    rng : not used.

    Returns
    -------
    History of one replicate, a row for the first grid and for each refinement.
    """
    here, best, value = box, box.low, math.inf
    position, values, counted = [], [], []
    for row in range(settings.refinements + 1):
        candidates = grid(here, settings.points)
        found = objective(candidates)
        index = int(np.argmin(found))
        if found[index] < value:
            best, value = candidates[index], float(found[index])
        position.append(best)
        values.append(value)
        counted.append((row + 1) * len(candidates))
        spacing = (here.high - here.low) / (settings.points - 1)
        here = Box(np.maximum(best - spacing, box.low), np.minimum(best + spacing, box.high))
    return History(np.array([counted]), np.array([position]), np.array([values]))


def replicate(objective: Objective, box: Box, settings: Settings, seed: int) -> History:
    """Return the one result as often as replicates are asked for; the seed does not matter."""
    once = minimise(objective, box, settings)
    return joined([once] * settings.replicates)
