"""Selection by the genetic algorithm of the paper: a string of row numbers, its fitness the network's error."""

from __future__ import annotations

from pipeline.grnn.selection.problem import Problem, Selected
from pipeline.search.genetic import Course, minimise
from pipeline.search.streams import Generators


def select(problem: Problem, random: Generators) -> Selected:
    """Return the best string of each replicate."""
    course = follow(problem, random)
    return Selected(course.strings(), course.history.best_value(), problem.evaluations)


def follow(problem: Problem, random: Generators) -> Course:
    """Return the whole course of the algorithm, all replicates together."""
    letters = len(problem.data.rate)
    return minimise(problem.errors, letters, problem.centres, problem.genetic, problem.generations, random)
