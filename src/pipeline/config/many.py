"""Many compositions, as of the runs of a sweep: files are merged once for each choice of them, values put into that.

What comes of it is what `compose_tree` makes of each run; whatever is more than plain values in place of plain values
is left to it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from hydra.core.override_parser.types import Override

from pipeline.config import adapter, interpolation
from pipeline.config.choices import chooses, parse
from pipeline.config.compose import Composed, choose, compose_tree, surrounding
from pipeline.config.inheritance import CONF, Layer, stamp

_WHOLE = re.compile(r"\$\{([A-Za-z_]\w*(?:\.\w+)*)\}", re.ASCII)
Place = tuple[str | int, ...]


class _Other(Exception):
    """More than plain values in place of plain values."""


class Memory:
    """Gives equal parts of configurations one identity, so that what follows from them is worked out once.

    Parts are told apart to the second level, by what they are written as: 1 is not 1.0.
    """

    def __init__(self) -> None:
        self._kept: dict[Any, Any] = {}
        self._known: set[int] = set()
        # Identity of a section that came as another one -> that one, kept alive, and the one that is kept.
        self._equal: dict[int, tuple[Any, Any]] = {}

    def tree(self, tree: Mapping[str, Any]) -> dict[str, Any]:
        """Return a tree whose sections, and entries of sections, are the ones that are kept."""
        return {key: self._section(key, value) for key, value in tree.items()}

    def _section(self, key: str, value: Any) -> Any:
        if id(value) in self._known:
            return value
        if not isinstance(value, dict):
            return self._keep((key, repr(value)), value)
        if id(value) not in self._equal:
            entries = {name: self._entry(key, name, one) for name, one in value.items()}
            kept = self._keep((key, tuple((name, id(one)) for name, one in entries.items())), entries)
            self._equal[id(value)] = value, kept
        return self._equal[id(value)][1]

    def _entry(self, section: str, name: str, value: Any) -> Any:
        return value if id(value) in self._known else self._keep((section, name, repr(value)), value)

    def _keep(self, key: Any, value: Any) -> Any:
        found = self._kept.setdefault(key, value)
        self._known.add(id(found))
        return found


class Unrefused:
    """A check that is not made again of the very same records, once it has refused nothing.

    Arguments
    ---------
    check : raises what is wrong with some frozen records; nothing else that it reads may change.
    """

    def __init__(self, check: Callable[..., object]) -> None:
        self._check = check
        # Identities -> the records, kept alive.
        self._passed: dict[tuple[int, ...], tuple[Any, ...]] = {}

    def __call__(self, *records: Any) -> None:
        """Check the records, unless these have passed before."""
        key = tuple(map(id, records))
        if key not in self._passed:
            self._check(*records)
            if len(self._passed) >= _MOST_PASSED:
                self._passed.clear()
            self._passed[key] = records


_MOST_PASSED = 10_000


@dataclass(frozen=True)
class _Family:
    """What runs have in common: files, and overrides that do more than change a value.

    `tree` has its interpolations resolved; `templates` says where they stood, and what they name.
    """

    tree: dict[str, Any]
    templates: Mapping[Place, tuple[str, ...]]
    layers: tuple[Layer, ...]
    odd: tuple[Override, ...]


class Compositions:
    """Composes run after run."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._state = stamp(CONF)
        self._words: dict[str, tuple[Override, bool]] = {}
        self._families: dict[tuple[Any, ...], _Family | None] = {}

    def compose(self, words: Sequence[str]) -> Composed:
        """Compose one run; arguments, result and errors are those of `compose_tree`."""
        typed = tuple(words)
        try:
            tree, layers = self._composed(typed)
        except _Other:
            found = compose_tree(typed)
            tree, layers = found.tree, found.layers
        return Composed(self._memory.tree(tree), typed, layers)

    def value(self, word: str) -> Any:
        """Return what an override of one value sets."""
        return self._word(word)[0].value()

    def _composed(self, words: tuple[str, ...]) -> tuple[dict[str, Any], tuple[Layer, ...]]:
        around = surrounding(words, CONF)
        parsed = [self._word(word) for word in (*around, *words)]
        choices = tuple(str(word.input_line) for word, is_choice in parsed if is_choice)
        values = [word for word, is_choice in parsed if not is_choice]
        tree = self._chosen(choices)
        odd = tuple(word for word in values if not _plain(word, tree))
        key = (choices, tuple(word.input_line for word in odd))
        if key not in self._families:
            self._families[key] = self._family(choices, odd)
        family = self._families[key]
        if family is None or any(_related(word, other) for word in values for other in odd if word is not other):
            raise _Other
        return _with(family, [word for word in values if word not in odd]), family.layers

    def _word(self, word: str) -> tuple[Override, bool]:
        if word not in self._words:
            (parsed,) = parse([word])
            if parsed.is_sweep_override():
                raise _Other
            self._words[word] = parsed, chooses(parsed, CONF)
        return self._words[word]

    def _chosen(self, choices: tuple[str, ...]) -> dict[str, Any]:
        try:
            return choose(choices, CONF, self._state).tree
        except Exception:  # told as for a single run
            raise _Other from None

    def _family(self, choices: tuple[str, ...], odd: tuple[Override, ...]) -> _Family | None:
        choice = choose(choices, CONF, self._state)
        try:
            tree = adapter.applied(choice.tree, odd) if odd else choice.tree
            interpolation.check(tree)
        except Exception:  # told as for a single run
            return None
        templates: dict[Place, tuple[str, ...]] = {}
        for place, text in _open(tree):
            named = _WHOLE.fullmatch(text)
            if named is None:
                return None
            templates[place] = tuple(named[1].split("."))
        made = _Family(tree, templates, choice.layers, odd)
        resolved = self._memory.tree(_with(made, []))
        return _Family(resolved, templates, choice.layers, odd)


def _plain(word: Override, tree: Mapping[str, Any]) -> bool:
    """Tell whether an override puts a plain value in place of what is no list, or a list in place of no mapping."""
    value, here = word.value(), tree
    if not adapter.changes(word) or not all(_is_plain(one) for one in (value if isinstance(value, list) else [value])):
        return False
    for key in word.key_or_group.split("."):
        if not isinstance(here, dict) or key not in here:
            return False
        here = here[key]
    return not isinstance(here, dict) if isinstance(value, list) else not isinstance(here, list)


def _is_plain(value: Any) -> bool:
    if isinstance(value, str):
        return "${" not in value and value != interpolation.MISSING
    return value is None or isinstance(value, bool | int | float)


def _related(word: Override, other: Override) -> bool:
    """Tell whether one of two overrides sets a part of what the other one does."""
    first, second = f"{word.key_or_group}.", f"{other.key_or_group}."
    return first.startswith(second) or second.startswith(first)


def _open(value: Any, place: Place = ()) -> Iterator[tuple[Place, str]]:
    """Yield the place and the text of every value that is not written out."""
    if isinstance(value, str):
        if "${" in value or value == interpolation.MISSING:
            yield place, value
    elif isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _open(part, (*place, key))


def _with(family: _Family, words: Sequence[Override]) -> dict[str, Any]:
    """Return the tree of a family with some plain values in it, and what follows them."""
    tree = family.tree
    templates = dict(family.templates)
    for word in words:
        keys = tuple(word.key_or_group.split("."))
        tree = _put(tree, keys, word.value())
        templates = {place: named for place, named in templates.items() if place[: len(keys)] != keys}
    for place in templates:
        value = _resolved(tree, templates, place)
        if not _same(_at(tree, place), value):
            tree = _put(tree, place, value)
    return tree


def _resolved(tree: Any, templates: Mapping[Place, tuple[str, ...]], place: Place, depth: int = 0) -> Any:
    here: Any = tree
    target: Place = ()
    for key in templates[place]:
        step: str | int = int(key) if isinstance(here, list) and key.isdecimal() else key
        try:
            here = here[step]
        except (KeyError, IndexError, TypeError):
            raise _Other from None
        target = (*target, step)
        if target in templates:
            if depth > len(templates):
                raise _Other
            here = _resolved(tree, templates, target, depth + 1)
    if any(_open(here)):
        raise _Other
    return deepcopy(here)


def _same(one: Any, other: Any) -> bool:
    return type(one) is type(other) and one == other


def _at(tree: Any, place: Place) -> Any:
    for key in place:
        tree = tree[key]
    return tree


def _put(tree: Any, place: Place, value: Any) -> Any:
    """Return a tree with another value at a place; all beside the way there is shared."""
    if not place:
        return value
    copy = tree.copy()
    copy[place[0]] = _put(tree[place[0]], place[1:], value)
    return copy
