"""Random exchange: a random string, one gene of it drawn anew at a time, kept where the error does not rise.

The simplest search that could do the genetic algorithm's work: no population, no crossover.
"""

from __future__ import annotations

import numpy as np

from pipeline.grnn.error import Candidates, errors
from pipeline.grnn.selection.problem import Array, Problem, Selected, Strings
from pipeline.jit import jit
from pipeline.search.streams import Generators


def select(problem: Problem, random: Generators) -> Selected:
    """Return where each replicate ended."""
    letters, tries = len(problem.data.rate), problem.evaluations - 1
    rows = np.stack([generator.integers(letters, size=problem.centres) for generator in random])
    places = np.stack([generator.integers(problem.centres, size=tries) for generator in random])
    drawn = np.stack([generator.integers(letters, size=tries) for generator in random])
    return Selected(rows, _walk(problem.table, rows, places, drawn), problem.evaluations)


@jit
def _walk(table: Candidates, rows: Strings, places: Strings, drawn: Strings) -> Array:
    """Try every exchange of every replicate, change the rows that it helps, and return the errors at the end."""
    error = errors(table, rows)
    for one in range(len(rows)):
        string = rows[one : one + 1]
        for attempt in range(places.shape[1]):
            place = places[one, attempt]
            before = string[0, place]
            string[0, place] = drawn[one, attempt]
            found = errors(table, string)[0]
            if found <= error[one]:
                error[one] = found
            else:
                string[0, place] = before
    return error
