"""A view of a configuration through which only its declared parts can be read.

What a step reads is declared once. Its settings are taken through this view, so that nothing else can enter them, and
the same declaration is the provenance of what the step makes.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import FunctionType, MethodType
from typing import Any


class UndeclaredRead(Exception):
    """A part of the configuration that a step reads without having declared it."""


def below(path: str, parts: Iterable[str]) -> bool:
    """Tell whether a key path is one of some parts of the configuration, or lies below one."""
    return any(path == part or path.startswith(f"{part}.") for part in parts)


def view(root: Any, reads: Iterable[str]) -> Any:
    """Return the view of a root record through some declared key paths."""
    return _Part(root, tuple(reads), "")


_MEMBERS: dict[tuple[type, str], Any] = {}


def member(record: type, name: str) -> Any:
    """Return what a class holds under a name, property or function as it stands there; None without one."""
    if (record, name) not in _MEMBERS:
        _MEMBERS[record, name] = inspect.getattr_static(record, name, None)
    return _MEMBERS[record, name]


class _View:
    """What a view of a record and one of a mapping share."""

    def __init__(self, value: Any, reads: tuple[str, ...], path: str) -> None:
        self._value, self._reads, self._path = value, reads, path

    def _taken(self, key: str, take: Callable[[], Any]) -> Any:
        path = f"{self._path}.{key}" if self._path else key
        if below(path, self._reads):
            return take()
        if not any(read.startswith(f"{path}.") for read in self._reads):
            declared = ", ".join(self._reads) or "nothing"
            raise UndeclaredRead(f"{path} is read and not declared; declared are: {declared}")
        value = take()
        if value is None:
            return None
        return _Entries(value, self._reads, path) if isinstance(value, Mapping) else _Part(value, self._reads, path)


class _Part(_View):
    """A record of which some fields may be read; its properties and methods see no more than that either."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__pydantic"):  # all that a record holds
            self.model_dump()
        if name.startswith("__"):
            raise AttributeError(name)
        found = member(type(self._value), name)
        if isinstance(found, property) and found.fget is not None:
            return found.fget(self)
        if isinstance(found, FunctionType):
            return MethodType(found, self)
        return self._taken(name, lambda: getattr(self._value, name))

    def sources_below(self, *parts: str) -> dict[str, Any]:
        """Return key path -> source of every parameter in some parts of the configuration, all of them declared."""
        for part in parts:
            if not below(part, self._reads):
                declared = ", ".join(self._reads) or "nothing"
                raise UndeclaredRead(f"sources of {part} are read and not declared; declared are: {declared}")
        return {path: source for path, source in self._value.sources.items() if below(path, parts)}

    def model_dump(self, **_: Any) -> Any:
        """Refuse to be taken whole."""
        raise UndeclaredRead(
            f"{self._path or 'the configuration'} is read whole; declared are: {', '.join(self._reads)}"
        )

    model_copy = model_dump


class _Entries(_View, Mapping[str, Any]):
    """A mapping of which some entries may be read; it is gone through only where all of them may."""

    def __getitem__(self, key: str) -> Any:
        return self._taken(key, lambda: self._value[key])

    def __iter__(self) -> Iterator[str]:
        for key in self._value:
            self._taken(key, lambda: None)
        return iter(self._value)

    def __len__(self) -> int:
        return len(self._value)
