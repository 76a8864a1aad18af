"""The experiments, found by their folders, and every list that follows from them."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec

from pipeline.kernel.experiment import EVERYTHING, FOUND, Experiment, Label, Step

PACKAGE = "pipeline.experiments"


@cache
def experiments() -> dict[str, Experiment]:
    """Return name -> experiment, those whose artefacts others take first.

    Raises
    ------
    ValueError : two experiments declare the same name of a step, or steps take each other's artefacts in a circle.
    """
    package = import_module(PACKAGE)
    names = [one.name for one in pkgutil.iter_modules(package.__path__)]
    found: dict[str, Experiment] = {name: import_module(f"{PACKAGE}.{name}").EXPERIMENT for name in names}
    owners = [(step.name, name) for name, one in found.items() for step in one.steps]
    twice = sorted({step for step, _ in owners if [name for name, _ in owners].count(step) > 1})
    if twice:
        raise ValueError(f"steps declared twice: {', '.join(twice)}")
    order = {name: place for place, name in enumerate(_order(found))}
    last = len(order)
    return dict(sorted(found.items(), key=lambda item: max((order[step.name] for step in item[1].steps), default=last)))


@cache
def steps() -> dict[str, Step]:
    """Return name -> step, in an order in which every step comes after those it takes from."""
    found = experiments()
    by_name = {step.name: step for one in found.values() for step in one.steps}
    return {name: by_name[name] for name in _order(found)}


@cache
def owners() -> dict[str, str]:
    """Return step -> the experiment that declares it."""
    return {step.name: name for name, one in experiments().items() for step in one.steps}


def takes(step: str) -> list[str]:
    """Return the steps whose artefacts a step takes, those that find values and `every step` written out."""
    return _takes(experiments())[step]


def module(step: str) -> str:
    """Return the dotted name of the module that runs a step."""
    return f"{PACKAGE}.{owners()[step]}.{step}"


@cache
def targets() -> dict[str, tuple[str, ...]]:
    """Return the parts of a run that people can ask for -> the steps that make them."""
    found: dict[str, tuple[str, ...]] = {}
    for step in steps().values():
        if step.target is not None:
            found[step.target] = (*found.get(step.target, ()), step.name)
    return found


@cache
def figures() -> dict[str, str]:
    """Return name of a drawing -> dotted name of its module: every module in `figures` of an experiment is one."""
    found: dict[str, str] = {}
    for name in experiments():
        for drawing in _modules(f"{PACKAGE}.{name}.figures"):
            if drawing in found:
                raise ValueError(f"two figures are called {drawing}: {found[drawing]} and that of {name}")
            found[drawing] = f"{PACKAGE}.{name}.figures.{drawing}"
    return found


def figure_owner(drawing: str) -> str:
    """Return the experiment that a drawing belongs to."""
    return figures()[drawing].split(".")[2]


@cache
def pages() -> dict[str, str]:
    """Return experiment -> dotted name of its module `page`, for those that have sections of the page."""
    names = {name: f"{PACKAGE}.{name}.page" for name in experiments()}
    return {name: dotted for name, dotted in names.items() if find_spec(dotted) is not None}


@cache
def labels() -> dict[str, Label]:
    """Return name -> part of the configuration that figures and pages show."""
    return {name: label for one in experiments().values() for name, label in one.labels.items()}


def _modules(package: str) -> Iterator[str]:
    spec = find_spec(package)
    for one in pkgutil.iter_modules((spec.submodule_search_locations if spec is not None else None) or ()):
        if not one.name.startswith("_"):
            yield one.name


def _takes(found: dict[str, Experiment]) -> dict[str, list[str]]:
    own = {step.name: name for name, one in found.items() for step in one.steps}
    finders = [step.name for one in found.values() for step in one.steps if step.finds]
    taken: dict[str, list[str]] = {}
    for name, one in found.items():
        others = [step for step, owner in own.items() if owner != name]
        for step in one.steps:
            words = {FOUND: finders, EVERYTHING: others}
            listed = [other for word in step.takes for other in words.get(word, [word])]
            taken[step.name] = [other for other in dict.fromkeys(listed) if other != step.name]
    return taken


def _order(found: dict[str, Experiment]) -> list[str]:
    """Return the names of all steps, each after those it takes from, which come just before the first that does."""
    taken = _takes(found)
    order: dict[str, None] = {}

    def visit(name: str, behind: tuple[str, ...]) -> None:
        if name in behind:
            raise ValueError(f"steps take from each other in a circle: {' -> '.join((*behind, name))}")
        if name not in taken:
            raise ValueError(f"no step {name!r}, which {behind[-1]} takes from")
        if name not in order:
            for other in taken[name]:
                visit(other, (*behind, name))
            order[name] = None

    for name in taken:
        visit(name, ())
    return list(order)
