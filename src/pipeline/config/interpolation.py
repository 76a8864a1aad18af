"""`${key.path}` in a configuration: names of other values and nothing else, and what they come to written out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pipeline.config.yaml_file import MOST_VALUES
from pipeline.errors import best_matches

_BEGINS = re.compile(r"(\\*)\$\{")
_NAME = re.compile(r"\s*(\.*)([A-Za-z_]\w*(?:\.\w+|\[\w+\])*)\s*\}", re.ASCII)
MOST_LETTERS = 1_000_000
MISSING = "???"


class Refused(Exception):
    """What stands at a key path is not to be resolved; the first argument is the path, the second says why."""


def check(tree: Mapping[str, Any]) -> None:
    """Refuse interpolations that reach outside the configuration, go in a circle, or grow without bound.

    Arguments
    ---------
    tree : the configuration with its interpolations as they are written.

    Raises
    ------
    Refused : with key path and reason.
    """
    _Weights(tree).of(tree, ())


class _Weights:
    """How many values and letters the parts of a tree come to, each counted once."""

    def __init__(self, tree: Mapping[str, Any]) -> None:
        self.tree = tree
        self.known: dict[tuple[str, ...], tuple[int, int]] = {}
        self.open: list[tuple[str, ...]] = []

    def of(self, value: Any, path: tuple[str, ...]) -> tuple[int, int]:
        if path in self.known:
            return self.known[path]
        if path in self.open:
            circle = " -> ".join(".".join(one) for one in [*self.open[self.open.index(path) :], path] if one)
            raise Refused(".".join(path), f"follows itself: {circle}")
        self.open.append(path)
        found = self._sum(value, path)
        self.open.pop()
        if found[0] > MOST_VALUES or found[1] > MOST_LETTERS:
            raise Refused(".".join(path), f"comes to more than {MOST_VALUES} values or {MOST_LETTERS} letters")
        self.known[path] = found
        return found

    def _sum(self, value: Any, path: tuple[str, ...]) -> tuple[int, int]:
        if isinstance(value, Mapping):
            parts = [self.of(part, (*path, str(key))) for key, part in value.items()]
        elif isinstance(value, list):
            parts = [self.of(part, (*path, str(place))) for place, part in enumerate(value)]
        elif isinstance(value, str):
            if value == MISSING:
                raise Refused(".".join(path), f"value {MISSING!r}, which is yet to be given; give it")
            parts = [self._named(value, begin, path) for begin in _BEGINS.finditer(value) if len(begin[1]) % 2 == 0]
            parts.append((0, len(value)))
        else:
            parts = []
        return 1 + sum(part[0] for part in parts), sum(part[1] for part in parts)

    def _named(self, text: str, begin: re.Match[str], path: tuple[str, ...]) -> tuple[int, int]:
        """Weigh what an interpolation names; it stands at a place in the text of a value."""
        where = ".".join(path)
        name = _NAME.match(text, begin.end())
        if name is None:
            told = text[begin.start() : begin.start() + 80]
            raise Refused(
                where,
                f"value {told!r}; ${{...}} may name another value of the configuration, as ${{battery.capacity_ah}}, "
                "and nothing outside it: no environment, no function, no other ${...}",
            )
        keys = tuple(re.split(r"[.\[]", name[2].replace("]", "")))
        target = (*path[: max(0, len(path) - len(name[1]))], *keys) if name[1] else keys
        here: Any = self.tree
        for depth, key in enumerate(target):
            inside = here if isinstance(here, Mapping) else dict(enumerate(here)) if isinstance(here, list) else {}
            entries = {str(one): part for one, part in inside.items()}
            if key not in entries:
                if isinstance(here, str) and "${" in here:  # named through another name
                    return self.of(here, target[:depth])
                parent = ".".join(target[:depth]) or "the configuration"
                raise Refused(where, f"{text}: {parent} has no key {key!r}; {best_matches(key, entries)}")
            here = entries[key]
        return self.of(here, target)
