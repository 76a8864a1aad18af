"""A node of the plan before it has a key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.record import Record


@dataclass(frozen=True)
class Draft:
    """A node before it has a key.

    `name` is unique in a run; `settings` is the node's own sub-tree; `inputs` maps the name under which the step
    finds an input to the name of the node that makes it; `sections` are the key paths of the configuration the
    node itself depends on; `shown` maps files of the artefact (`*`: all of them, names kept) to places in the
    readable view, which is under `results/` or `reports/`; `modules` are those the step imports by a name that stands
    in its settings.
    """

    step: str
    name: str
    label: str
    settings: dict[str, Any]
    inputs: dict[str, str] = field(default_factory=dict)
    sections: tuple[str, ...] = ()
    shown: dict[str, str] = field(default_factory=dict)
    view: str = "results"
    modules: tuple[str, ...] = ()


def plain(value: Any) -> Any:
    """Return a record, or a structure of records, as plain data."""
    if isinstance(value, Record):
        return value.model_dump(mode="json", by_alias=True)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def references(values: Any) -> Iterator[str]:
    """Yield the step of every reference `{from: step, value: name}` in plain data."""
    if isinstance(values, Mapping):
        if set(values) == {"from", "value"}:
            yield str(values["from"])
            return
        for value in values.values():
            yield from references(value)
    elif isinstance(values, list | tuple):
        for value in values:
            yield from references(value)


def with_found(draft: Draft) -> Draft:
    """Return a node with an edge from each step whose found value its settings ask for."""
    return replace(draft, inputs={name: name for name in sorted(set(references(draft.settings)))} | draft.inputs)


def needed(nodes: list[Draft], only_if_asked: frozenset[str]) -> list[Draft]:
    """Return the nodes without those of some steps that no other node asks for, directly or through others."""
    by_name = {node.name: node for node in nodes}
    waiting = [node.name for node in nodes if node.step not in only_if_asked]
    kept = set[str]()
    while waiting:
        name = waiting.pop()
        if name not in kept:
            kept.add(name)
            waiting.extend(by_name[name].inputs.values())
    return [node for node in nodes if node.name in kept]
