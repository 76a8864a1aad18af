"""What every selection of centres gets, and what it hands back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.grnn.error import Candidates, Form, candidates, errors
from pipeline.grnn.records import Data
from pipeline.search.genetic import GeneticSettings

Array = NDArray[np.float64]
Strings = NDArray[np.int64]


class Problem(NamedTuple):
    """Which rows of the data should be the centres of a network of one form."""

    data: Data
    form: Form
    table: Candidates
    centres: int
    """How many [1]."""
    genetic: GeneticSettings
    generations: int
    """Of the genetic algorithm; all others have as many evaluations as it takes for them."""

    @property
    def evaluations(self) -> int:
        """Return how many networks may be evaluated."""
        return self.genetic.evaluations(self.generations)

    def errors(self, strings: Strings) -> Array:
        """Return the mean square errors [C-rate^2] of networks, rows as strings (s, n), all at once."""
        return errors(self.table, np.ascontiguousarray(strings))


class Selected(NamedTuple):
    """Selections of centres: a row of each for every replicate, one alone where nothing is random."""

    rows: Strings
    """Rows of the data, shape (r, n), from 0."""
    error: Array
    """Mean square error [C-rate^2], shape (r,)."""
    evaluations: int
    """Networks evaluated for each."""

    def best(self) -> Strings:
        """Return the rows of the best replicate, shape (n,)."""
        rows: Strings = self.rows[int(np.argmin(self.error))]
        return rows


def problem_of(data: Data, form: Form, centres: int, genetic: GeneticSettings, generations: int) -> Problem:
    """Return the problem; raise ValueError where the data has fewer rows than centres are asked for."""
    if not 1 <= centres <= len(data.rate):
        raise ValueError(f"{centres} centres of {len(data.rate)} points; allowed are 1 to {len(data.rate)}")
    return Problem(data, form, candidates(data, form), centres, genetic, generations)


def once(problem: Problem, strings: Strings) -> Selected:
    """Return selections, shape (r, n), that were made without evaluating a network."""
    return Selected(strings, problem.errors(strings), 1)
