"""Named numbers, and the vocabularies in which a step declares those that it finds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product
from string import Formatter
from typing import NamedTuple


class Quantity(NamedTuple):
    """A named number with its unit and meaning; NaN where there is none."""

    name: str
    value: float
    unit: str
    description: str


class Meaning(NamedTuple):
    """Unit and meaning of a number; fields in braces stand for what its name says in the same place."""

    unit: str
    description: str


class Vocabulary:
    """The numbers that a step finds, each declared once: name or pattern of names, unit, meaning.

    Arguments
    ---------
    words : name, perhaps with fields in braces as `{search}_frequency_hz` -> unit and meaning. The unit and the meaning
        may use the fields too.
    """

    def __init__(self, words: Mapping[str, tuple[str, str]]) -> None:
        self.words = {pattern: Meaning(*meaning) for pattern, meaning in words.items()}
        self._fields = {pattern: fields(pattern) for pattern in words}

    def __or__(self, other: Vocabulary) -> Vocabulary:
        """Return both vocabularies as one."""
        return Vocabulary({**self.words, **other.words})

    def quantity(self, pattern: str, value: float, **named: object) -> Quantity:
        """Return a number under a declared name.

        Arguments
        ---------
        pattern : the name as declared, its fields in braces.
        value : the number; NaN where there is none.
        named : what each field stands for.

        Raises
        ------
        KeyError : the pattern is not declared, or one of its fields is not named.
        """
        unit, description = self.words[pattern]
        return Quantity(pattern.format(**named), float(value), unit.format(**named), description.format(**named))

    def names(self, values: Mapping[str, Iterable[object]]) -> set[str]:
        """Return every name, for the values that the fields may take; none of a pattern with a field without values."""
        known = {name: [str(value) for value in listed] for name, listed in values.items()}
        return {
            pattern.format(**dict(zip(names, chosen, strict=True)))
            for pattern, names in self._fields.items()
            for chosen in product(*(known.get(name, ()) for name in names))
        }


def fields(pattern: str) -> tuple[str, ...]:
    """Return the names of the fields of a pattern, each once."""
    return tuple(dict.fromkeys(name for _, name, _, _ in Formatter().parse(pattern) if name))
