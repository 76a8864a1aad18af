"""Parameter designs and their orthogonal arrays, published or standard; level numbers count from 0 here."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pipeline.errors import UserError, best_matches
from pipeline.record import Record

Array = NDArray[np.float64]
Levels = NDArray[np.int64]


def rows(design: Design) -> Levels:
    """Return the design's array, a row per run and a column per factor, shape (m, k)."""
    if isinstance(design.array, str):
        return standard(design.array, [len(levels) for levels in design.factors.values()])
    return np.array(design.array, dtype=np.int64) - 1


def standard(name: str, level_counts: Sequence[int]) -> Levels:
    """Return the first columns of a standard array that have the levels asked for.

    Arguments
    ---------
    name : as pydoe spells it, e.g. `L16(4^5)`.
    level_counts : number of levels of each factor.

    Raises
    ------
    UserError : no such array, or not enough columns of that many levels.
    """
    from pydoe import get_orthogonal_array, list_orthogonal_arrays

    known = list_orthogonal_arrays()
    if name not in known:
        raise UserError(f"array: no standard array {name!r}; {best_matches(name, known)}")
    whole = np.asarray(get_orthogonal_array(name), dtype=np.int64)
    free = list(range(whole.shape[1]))
    chosen: list[int] = []
    for count in level_counts:
        column = next((index for index in free if int(whole[:, index].max()) + 1 == count), None)
        if column is None:
            raise UserError(f"array: {name} has no columns for factors of {list(level_counts)} levels")
        chosen.append(column)
        free.remove(column)
    return whole[:, chosen]


def full_factorial(level_counts: Sequence[int]) -> Levels:
    """Return every combination of levels, the last factor fastest, shape (product of the counts, k)."""
    return np.array(list(itertools.product(*(range(count) for count in level_counts))), dtype=np.int64)


def index_in_factorial(array: Levels, level_counts: Sequence[int]) -> Levels:
    """Return which row of the full factorial each run is, shape (m,)."""
    return np.asarray(np.ravel_multi_index(tuple(array.T), tuple(level_counts)), dtype=np.int64)


def is_orthogonal(array: Levels) -> bool:
    """Tell whether in every pair of columns all combinations of their levels occur equally often (strength 2)."""
    counts = array.max(axis=0) + 1
    for first, second in itertools.combinations(range(array.shape[1]), 2):
        seen = np.bincount(
            array[:, first] * counts[second] + array[:, second], minlength=counts[first] * counts[second]
        )
        if seen.min() != seen.max():
            return False
    return True


def factor_values(design: Design, array: Levels) -> dict[str, Array]:
    """Return what each factor is set to in each run of an array, shape (m,) each."""
    return {name: np.array(levels)[array[:, index]] for index, (name, levels) in enumerate(design.factors.items())}


class Design(Record):
    """Factors with their levels, and the runs of the array."""

    title: str = Field(min_length=1, description="name of the design, for people")
    factors: dict[str, tuple[float, ...]] = Field(min_length=1, description="factor -> its levels, L1 first [1]")
    array: str | tuple[tuple[int, ...], ...] = Field(
        description="a row per run, in it the number of each factor's level from 1; or a standard array, `L16(4^5)`"
    )
    printed: str | None = Field(
        default=None, description="table of a paper's results for these factors, in conf/published/reference"
    )
    replicates: int = Field(ge=1, description="searches per run of the array, each with a random stream of its own")
    factorial_replicates: int = Field(
        ge=0, description="searches per combination of the full factorial that checks the array; 0: none"
    )
    statistic: Literal["cumulative", "final"] = Field(
        description="what a search counts for: the best value summed over its iterations, or the best at its end"
    )

    @model_validator(mode="after")
    def _levels_exist(self) -> Design:
        for name, levels in self.factors.items():
            if len(set(levels)) != len(levels) or len(levels) < 2:
                raise ValueError(f"factors.{name} is {list(levels)}; it must hold two or more levels, all different")
        if isinstance(self.array, str):
            return self
        counts = [len(levels) for levels in self.factors.values()]
        for number, row in enumerate(self.array, start=1):
            if len(row) != len(counts):
                raise ValueError(f"array row {number} has {len(row)} entries; the design has {len(counts)} factors")
            for (name, levels), level in zip(self.factors.items(), row, strict=True):
                if not 1 <= level <= len(levels):
                    raise ValueError(
                        f"array row {number} has level {level} of {name}; its levels are 1 to {len(levels)}"
                    )
        return self
