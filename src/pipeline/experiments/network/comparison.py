"""Selections of centres held against each other, each at the widths that suit it, on one number of evaluations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.network.records import FormSettings, KernelStudy, SelectionSettings, SizeStudy
from pipeline.grnn.error import Form
from pipeline.grnn.network import KERNELS
from pipeline.grnn.records import Data, Kernel, Method
from pipeline.grnn.selection import genetic, greedy
from pipeline.grnn.selection.methods import SELECT, Task, Trial, trials
from pipeline.grnn.selection.problem import Selected
from pipeline.search.genetic import Course, GeneticSettings
from pipeline.search.streams import generators

Array = NDArray[np.float64]


class Result(NamedTuple):
    """A method's widths, how they were found, and its selections."""

    form: Form
    trials: list[Trial]
    selected: Selected


class Comparison(NamedTuple):
    """Every method's result, and the whole course of the genetic algorithm, beyond the generations that are used."""

    results: dict[Method, Result]
    course: Course


def units(centres: int) -> int:
    """Return the processing units as the paper counts them: 13 for six centres, 1123 for all 561 points."""
    return 2 * centres + 1


def compare(form: FormSettings, settings: SelectionSettings, data: Data, seed: int) -> Comparison:
    """Select centres by every method of the settings; replicate i draws from SeedSequence([seed, i])."""
    task = task_of(data, form, settings.genetic)
    random = generators(seed, 0, settings.replicates)
    results: dict[Method, Result] = {}
    course: Course | None = None
    for method in settings.methods:
        found = trials(method, task, form.widths, settings.generations, seed)
        chosen = found[0].widths
        if method == "genetic":
            course = genetic.follow(task.problem(chosen, settings.long_generations), random)
            selected = after(course, settings.generations)
        else:
            random = generators(seed, 0, settings.replicates)
            selected = SELECT[method](task.problem(chosen, settings.generations), random)
        results[method] = Result(Form(task.kernel, chosen, task.extension), found, selected)
    assert course is not None
    return Comparison(results, course)


def task_of(data: Data, form: FormSettings, settings: GeneticSettings) -> Task:
    """Return the task of a study's form."""
    return Task(data, form.kernel, form.extension, form.centres, settings)


def after(course: Course, generation: int) -> Selected:
    """Return where the replicates of the genetic algorithm stood after a generation."""
    history = course.history
    rows = history.position[:, generation].astype(np.int64)
    return Selected(rows, history.value[:, generation], int(history.evaluations[0, generation]))


class Size(NamedTuple):
    """Networks of one number of centres: by the genetic algorithm, and by forward selection alone."""

    centres: int
    widths: tuple[float, float]
    error: Array
    """Mean square error of each replicate, shape (r,) [C-rate^2]."""
    forward_error: float


def sizes(form: FormSettings, settings: GeneticSettings, study: SizeStudy, data: Data, seed: int) -> Iterator[Size]:
    """Yield the error against the number of centres."""
    largest = task_of(data, form, settings)._replace(centres=study.largest)
    forward = _forward(largest, form)
    for centres in range(study.smallest, study.largest + 1):
        task = largest._replace(centres=centres)
        chosen = trials("genetic", task, form.widths, study.generations, seed)[0].widths
        selected = genetic.select(task.problem(chosen, study.generations), generators(seed, 0, study.replicates))
        yield Size(centres, chosen, selected.error, float(forward[centres - 1]))


def _forward(task: Task, form: FormSettings) -> Array:
    """Return the error of forward selection at 1, 2, ... centres, each at the widths that suit it."""
    found = np.array([greedy.forward(task.problem(pair, 1))[1] for pair in form.widths.pairs()])
    least: Array = np.min(found, axis=0)
    return least


class Variety(NamedTuple):
    """A kernel on a surface."""

    surface: str
    kernel: Kernel
    widths: tuple[float, float]
    error: Array
    """Mean square error of each replicate, shape (r,) [C-rate^2]."""


def varieties(
    form: FormSettings, settings: GeneticSettings, study: KernelStudy, surfaces: Mapping[str, Data], seed: int
) -> Iterator[Variety]:
    """Yield every kernel on every surface."""
    for name, data in surfaces.items():
        for kernel in KERNELS:
            task = task_of(data, form, settings)._replace(kernel=kernel)
            chosen = trials("genetic", task, form.widths, study.generations, seed)[0].widths
            selected = genetic.select(task.problem(chosen, study.generations), generators(seed, 0, study.replicates))
            yield Variety(name, kernel, chosen, selected.error)
