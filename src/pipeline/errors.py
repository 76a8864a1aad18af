"""The one exception that means: the person at the keyboard can mend this."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class UserError(Exception):
    """A mistake in what was asked for; printed as one message, exit code 2, no traceback."""


def closest(name: str, known: Iterable[str], most: int = 3) -> list[str]:
    """Return up to `most` of the `known` names that look like `name`, capitals or not, best first."""
    plain = {one.lower(): one for one in sorted(set(known), reverse=True)}
    return [plain[one] for one in difflib.get_close_matches(name.lower(), sorted(plain), n=most, cutoff=0.5)]


def best_matches(name: str, known: Iterable[str]) -> str:
    """Return a sentence that names the closest known names, or all of them where none is close."""
    names = sorted(set(known))
    near = closest(name, names)
    if near:
        return "best matches are: " + ", ".join(near)
    return "known are: " + (", ".join(names) if names else "none")


class EngineError(RuntimeError):
    """A charge could not be computed to its end; the message says where it stood."""
