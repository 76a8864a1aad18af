"""Files that build on one another: whoever changes a value says where the new one comes from.

Hydra would merge the sources like the values, and a changed value would keep the source of the one it replaces.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from pipeline.config.yaml_file import document, shown
from pipeline.errors import UserError
from pipeline.kernel.places import PROJECT, confs

CONF = PROJECT / "conf"
Stamp = tuple[tuple[str, int, int], ...]


@dataclass(frozen=True)
class Layer:
    """A file that takes part in a configuration, and the key path under which its content stands."""

    place: tuple[str, ...]
    file: Path

    @property
    def tree(self) -> dict[str, Any]:
        """Return what the file holds, at its place."""
        tree: dict[str, Any] = {key: value for key, value in content(self.file).items() if key != "defaults"}
        for key in reversed(self.place):
            tree = {key: tree}
        return tree

    def depth(self, keys: Sequence[str]) -> int:
        """Return how many of some keys, from the first, the file sets."""
        here: Any = self.tree
        for count, key in enumerate(keys):
            if not isinstance(here, Mapping) or key not in here:
                return count
            here = here[key]
        return len(keys)

    def line(self, keys: Sequence[str]) -> str:
        """Return the file, and the line that sets the last of some keys."""
        return f"{shown(self.file)}:{locate(self.file, keys[len(self.place) :])}"


def content(path: Path) -> dict[str, Any]:
    """Return what a YAML file holds; shared by all who ask, so not to be changed."""
    return document(path).tree


def roots(conf: Path) -> tuple[Path, ...]:
    """Return the folders that a configuration is searched in: of the project's own also the one that is shipped."""
    return confs() if conf == CONF else (conf,)


def file_of(conf: Path, name: str) -> Path:
    """Return a file of a configuration by its name there, from the first folder that has it."""
    return next((root / name for root in roots(conf) if (root / name).is_file()), conf / name)


def is_group(conf: Path, name: str) -> bool:
    """Tell whether a configuration has a group of some name."""
    try:
        return bool(re.fullmatch(r"[\w/-]+", name)) and any((root / name).is_dir() for root in roots(conf))
    except (OSError, ValueError):
        return False


def within(conf: Path, file: Path) -> PurePosixPath:
    """Return a file's name inside the folder of configuration that it lies in."""
    root = next(root for root in roots(conf) if file.is_relative_to(root))
    return PurePosixPath(file.relative_to(root))


def _state(path: Path) -> tuple[int, int]:
    # What cannot be read counts too, as it is: it is told where it is chosen.
    status = path.stat() if path.exists() else path.lstat()
    return status.st_mtime_ns, status.st_size


def stamp(conf: Path) -> Stamp:
    """Return the state of every YAML file of a configuration: another one after an edit."""
    files = (path for root in roots(conf) for path in sorted(root.rglob("*.yaml")))
    return tuple((path.as_posix(), *_state(path)) for path in files)


def locate(path: Path, keys: Sequence[str]) -> int:
    """Return the line of the last of some keys, from the first, that a YAML file has."""
    lines = document(path).lines
    here: tuple[str | int, ...] = ()
    line = 1
    for key in keys:
        here = (*here, key) if (*here, key) in lines else (*here, int(key)) if key.isdecimal() else (*here, key)
        if here not in lines:
            break
        line = lines[here]
    return line


Place = tuple[str, ...]
Sources = dict[Place, tuple[Place, Any]]
"""Key path of a value -> the key path that its `sources` stands under, and the source."""


class _Found(Sources):
    """Sources as they are found, and every beginning of the key paths that ever had one."""

    def __init__(self) -> None:
        super().__init__()
        self._beginnings: set[Place] = set()

    def put(self, path: Place, entry: tuple[Place, Any]) -> None:
        """Give a value its source."""
        self[path] = entry
        self._beginnings.update(path[:count] for count in range(1, len(path) + 1))

    def below(self, path: Place) -> list[Place]:
        """Return the key paths with a source that are this one or lie below it."""
        if path not in self._beginnings:
            return []
        return [other for other in self if other[: len(path)] == path]


def merge(layers: Sequence[Layer]) -> dict[str, Any]:
    """Return the tree that files come to, as Hydra merges them, with the sources that hold for its values.

    Mappings are joined; of anything else the last one stays.

    Arguments
    ---------
    layers : the files in the order in which they are merged.
    """
    tree: dict[str, Any] = {}
    sources = _Found()
    for layer in layers:
        values, said = _divided(layer)
        for path in list(_changed(tree, values)):
            _drop(sources, path, tree)
        _join(tree, values)
        for path, entry in said.items():
            _drop(sources, path, tree)
            sources.put(path, entry)
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


def _drop(sources: _Found, path: Place, values: Mapping[str, Any]) -> None:
    """Take the source from a value, and leave it to the others that had the same one."""
    for other in sources.below(path):
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
                    for other in rest:
                        if other not in sources:
                            sources.put(other, entry)
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
