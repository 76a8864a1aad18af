"""Files that build on one another: whoever changes a value says where the new one comes from.

Hydra would merge the sources like the values, and a changed value would keep the source of the one it replaces.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.config.files import Layer
from pipeline.errors import UserError

Place = tuple[str, ...]
Sources = dict[Place, tuple[Place, Any]]
"""Key path of a value -> the key path that its `sources` stands under, and the source."""


def merge(layers: Sequence[Layer]) -> dict[str, Any]:
    """Return the tree that files come to, as Hydra merges them, with the sources that hold for its values.

    Mappings are joined; of anything else the last one stays.

    Arguments
    ---------
    layers : the files in the order in which they are merged.
    """
    tree: dict[str, Any] = {}
    sources: Sources = {}
    for layer in layers:
        values, said = _divided(layer)
        for path in list(_changed(tree, values)):
            _drop(sources, path, tree)
        _join(tree, values)
        for path, entry in said.items():
            _drop(sources, path, tree)
            sources[path] = entry
    for path, (place, source) in sources.items():
        here = tree
        for key in (*place, "sources", *path[len(place) : -1]):
            here = here.setdefault(key, {})
        here[path[-1]] = source
    return tree


def _divided(layer: Layer) -> tuple[dict[str, Any], Sources]:
    """Return the values that a file sets, and the sources it gives."""
    sources: Sources = {}
    for place, written in _written(layer.tree):
        if not isinstance(written, Mapping):
            path = ".".join((*place, "sources"))
            raise UserError(
                f"{layer.line([*place, 'sources'])}: {path}: value {written!r}; "
                "allowed is a mapping with the names of the values"
            )
        sources |= {(*place, *path): (place, source) for path, source in _flat(written)}
    return _without(layer.tree), sources


def _written(tree: Mapping[str, Any], place: Place = ()) -> Iterator[tuple[Place, Any]]:
    for key, value in tree.items():
        if key == "sources":
            yield place, value
        elif isinstance(value, Mapping):
            yield from _written(value, (*place, str(key)))


def _flat(sources: Mapping[str, Any], path: Place = ()) -> Iterator[tuple[Place, Any]]:
    for key, value in sources.items():
        if isinstance(value, Mapping) and "kind" not in value:
            yield from _flat(value, (*path, str(key)))
        else:
            yield (*path, str(key)), value


def _without(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Copy a tree without its sources."""
    return {
        key: _without(value) if isinstance(value, Mapping) else value for key, value in tree.items() if key != "sources"
    }


def _changed(old: Mapping[str, Any], new: Mapping[str, Any], path: Place = ()) -> Iterator[Place]:
    """Yield the key path of every value that is not what it was, or was not there."""
    for key, value in new.items():
        before = old.get(key)
        if isinstance(value, Mapping):
            yield from _changed(before if isinstance(before, Mapping) else {}, value, (*path, str(key)))
        elif key not in old or before != value:
            yield (*path, str(key))


def _drop(sources: Sources, path: Place, values: Mapping[str, Any]) -> None:
    """Take the source from a value, and leave it to the others that had the same one."""
    for other in [other for other in sources if other[: len(path)] == path]:
        del sources[other]
    for depth in range(len(path) - 1, 0, -1):
        if path[:depth] in sources:
            entry = sources.pop(path[:depth])
            here: Any = values
            for place, key in enumerate(path):
                if not isinstance(here, Mapping):
                    return
                if place >= depth:
                    rest = [(*path[:place], str(other)) for other in here if other != key and _counts(here[other])]
                    sources |= {other: entry for other in rest if other not in sources}
                here = here.get(key)
            return


def _counts(value: Any) -> bool:
    """Tell whether a value is, or holds, something that has a source: no word or switch."""
    if isinstance(value, Mapping):
        return any(_counts(part) for part in value.values())
    return isinstance(value, list) or not isinstance(value, str | bool | None) or "${" in str(value)


def _join(tree: dict[str, Any], new: Mapping[str, Any]) -> None:
    for key, value in new.items():
        if isinstance(value, Mapping):
            here = tree.get(key)
            tree[key] = here if isinstance(here, dict) else {}
            _join(tree[key], value)
        else:
            tree[key] = value
