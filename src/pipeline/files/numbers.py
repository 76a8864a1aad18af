"""Numbers as people write them in files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

from pipeline.files import units

_POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d+", re.ASCII)


def number(value: Any, decimal: str = ".") -> float | None:
    """Return a value as a finite number; none where it is not one: a word, a truth value, digits of other scripts.

    Arguments
    ---------
    value : as it stands in the file.
    decimal : the file's decimal sign, for text; with a comma, points between groups of three digits are left out.
    """
    if isinstance(value, str):
        text = value.strip()
        if decimal == ",":
            text = text.replace(".", "").replace(",", ".") if _GROUPED.fullmatch(text) else text.replace(",", ".")
        if not _POINT.fullmatch(text):
            return None
        found = float(text)
    elif value is None or isinstance(value, bool) or not hasattr(value, "__float__"):
        return None
    else:
        found = float(value)
    return found if math.isfinite(found) else None


def decimal_of(cells: Iterable[str]) -> str:
    """Return the decimal sign that a text file's cells are written with: a comma where only commas are."""
    commas = points = 0
    for cell in cells:
        text = cell.strip()
        commas += bool(_COMMA.fullmatch(text) or _GROUPED.fullmatch(text))
        points += "." in text and bool(_POINT.fullmatch(text))
    return "," if commas and not points else "."


def shown(value: Any) -> str:
    """Return a value as a message says it."""
    if value is None or value == "":
        return "empty"
    return f"value {value!r}" if isinstance(value, str) else f"value {value}"


_HEIGHT = re.compile(r"(?:at|@)?\s*\d+(?:\.\d+)?\s*(?:m|ft|feet)\b|_?\d+m$", re.IGNORECASE)


def plain(heading: str) -> str:
    """Return a heading as a word: without its unit, capitals, spaces and signs."""
    return re.sub(r"[^a-z0-9]", "", _folded(units.split(heading)[0]))


def bare(heading: str) -> str:
    """Return a heading as a word, without the height above ground at which something was measured too."""
    return re.sub(r"[^a-z0-9]", "", _folded(_HEIGHT.sub("", units.split(heading)[0])))


def _folded(text: str) -> str:
    return text.lower().replace("ä", "ae").replace("ö", "oe").replace("ü", "ue").replace("é", "e")
