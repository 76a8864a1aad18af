"""Nodes of the plan before they have keys: their settings taken through what they declare to read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import product
from string import Formatter
from typing import Any

from pipeline.kernel import registry
from pipeline.kernel.experiment import Draft, Node
from pipeline.kernel.scope import view


def drafts(study: Any) -> list[Draft]:
    """Return the nodes of a study, inputs before those that read them.

    Arguments
    ---------
    study : the root record of its configuration.

    Raises
    ------
    UndeclaredRead : settings that read what their step does not declare.
    """
    experiments = registry.experiments().values()
    makers = [one for one in experiments if one.alone(study)] or experiments
    order = {name: place for place, name in enumerate(registry.steps())}
    made = [drafted(node, study) for one in makers for node in one.nodes(study)]
    made.sort(key=lambda node: order[node.step])
    made = needed(made, {name for name, step in registry.steps().items() if step.on_demand})
    for one in experiments:
        if one.closing is not None:
            for node in tuple(one.closing(study, made)):
                made.append(drafted(node, study))
    return made


def drafted(node: Node, study: Any) -> Draft:
    """Return a node with its settings, an edge from each step whose found values they ask for."""
    reads = tuple(path for read in node.step.reads for path in paths(read, node.which))
    settings = plain(dict(node.step.settings(view(study, reads), **node.which)))
    found = {name: name for name in sorted(set(references(settings)))}
    return Draft(
        node.step.name,
        node.name,
        node.label,
        settings,
        found | dict(node.inputs),
        reads,
        dict(node.shown),
        node.room,
        node.modules,
        None if node.step.effort is None else node.step.effort(study, **node.which),
    )


def paths(read: str, which: Mapping[str, Any]) -> Iterator[str]:
    """Yield the key paths that a declared read stands for; none where a field in it has no value."""
    names = _fields(read)
    if not names:
        yield read
        return
    choices = [_words(which[name]) for name in names]
    for words in product(*choices):
        yield read.format(**dict(zip(names, words, strict=True)))


@cache
def _fields(read: str) -> tuple[str, ...]:
    return tuple(name for _, name, _, _ in Formatter().parse(read) if name)


def _words(value: Any) -> list[Any]:
    if value is None:
        return []
    return [value] if isinstance(value, str) else list(value)


def untitled(record: Any, name: str) -> dict[str, Any]:
    """Return a record with its name for a title: titles are for readers, and changing one must compute nothing."""
    return {**plain(record), "title": name}


def plain(value: Any) -> Any:
    """Return a record, or a structure of records, as plain data."""
    if hasattr(value, "model_dump"):
        return value.model_dump(mode="json", by_alias=True)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


_REFERENCE = {"from", "value"}


def references(values: Any) -> Iterator[str]:
    """Yield the step of every reference `{from: step, value: name}` in plain data."""
    if isinstance(values, dict) and values.keys() == _REFERENCE:
        yield str(values["from"])
    elif isinstance(values, dict | list | tuple):
        for value in values.values() if isinstance(values, dict) else values:
            if not isinstance(value, str | float | int):
                yield from references(value)


def needed(nodes: Sequence[Draft], only_if_asked: Collection[str]) -> list[Draft]:
    """Return the nodes without those of some steps that no other node asks for, directly or through others."""
    by_name = {node.name: node for node in nodes}
    kept = behind(by_name, (node.name for node in nodes if node.step not in only_if_asked))
    return [node for node in nodes if node.name in kept]


def behind(by_name: Mapping[str, Draft], names: Iterable[str]) -> set[str]:
    """Return some nodes and all that they are made from, through the edges of the plan."""
    return reached(names, lambda name: by_name[name].inputs.values())


def reached(names: Iterable[str], onward: Callable[[str], Iterable[str]]) -> set[str]:
    """Return some names and all that are reached from them.

    Arguments
    ---------
    onward : name -> the names that it leads to.
    """
    waiting, seen = list(names), set[str]()
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting.extend(onward(name))
    return seen


def reads_behind(by_name: Mapping[str, Draft], names: Iterable[str]) -> tuple[str, ...]:
    """Return the key paths of the configuration that some nodes depend on, through the edges of the plan."""
    return tuple(dict.fromkeys(path for name in sorted(behind(by_name, names)) for path in by_name[name].reads))
