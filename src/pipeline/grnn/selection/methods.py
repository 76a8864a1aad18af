"""All selections by name, and the choice of the widths for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pipeline.grnn.error import Form
from pipeline.grnn.records import Data, Kernel, Method, Widths
from pipeline.grnn.selection import baselines, exchange, genetic, greedy, least_squares, medoids
from pipeline.grnn.selection.problem import Problem, Selected, problem_of
from pipeline.search.genetic import GeneticSettings
from pipeline.search.streams import Generators, generators

SELECT: dict[Method, Callable[[Problem, Generators], Selected]] = {
    "genetic": genetic.select,
    "exchange": exchange.select,
    "random_best": baselines.best_of_random,
    "greedy": greedy.select,
    "least_squares": least_squares.select,
    "medoids": medoids.select,
    "random": baselines.random_rows,
    "regular": baselines.regular_grid,
}

# Streams of the widths' trials lie far from those of the replicates: no selection is judged by its own trial.
FIRST_TRIAL, FIRST_FINAL = 1_000_000, 2_000_000
# A method that evaluates one network varies more and costs less: its trials have more replicates.
SINGLE: frozenset[Method] = frozenset({"least_squares", "medoids", "random", "regular"})
_MORE = 10


class Task(NamedTuple):
    """What is to be selected, the widths still open."""

    data: Data
    kernel: Kernel
    extension: float
    centres: int
    genetic: GeneticSettings

    def problem(self, widths: tuple[float, float], generations: int) -> Problem:
        """Return the task with its widths and its budget."""
        form = Form(self.kernel, widths, self.extension)
        return problem_of(self.data, form, self.centres, self.genetic, generations)


class Trial(NamedTuple):
    """A pair of widths and the mean square error it came to, mean over the trial's replicates [C-rate^2]."""

    widths: tuple[float, float]
    error: float


def trials(method: Method, task: Task, widths: Widths, generations: int, seed: int) -> list[Trial]:
    """Try every pair of widths with a method, and the best of them once more with all generations' evaluations.

    All pairs see the same random streams.

    Returns
    -------
    The pairs, those that were tried again first and with that error.
    """
    count = widths.trial_replicates * (_MORE if method in SINGLE else 1)

    def tried(pair: tuple[float, float], budget: int, first: int) -> Trial:
        chosen = SELECT[method](task.problem(pair, budget), generators(seed, first, count))
        return Trial(pair, float(np.mean(chosen.error)))

    found = sorted(
        (tried(pair, widths.trial_generations, FIRST_TRIAL) for pair in widths.pairs()), key=lambda one: one.error
    )
    again = [tried(one.widths, generations, FIRST_FINAL) for one in found[: widths.finalists]]
    return sorted(again, key=lambda one: one.error) + found[widths.finalists :]
