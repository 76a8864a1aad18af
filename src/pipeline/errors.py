"""Errors for people, and the names they may have meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from pipeline.kernel.errors import EngineError, UserError

__all__ = ["EngineError", "UserError", "best_matches", "closest"]


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
