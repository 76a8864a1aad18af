"""Numbers, units and names as a page prints them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

from pipeline.report.tables import Cell, plain

DIGITS = 4
"""Significant digits of a number on the page; the CSV files have more."""
ROUNDING = 1e-11
"""Share of the largest number of a column below which another is what rounding left over."""
NOTHING = "–"
_EXPONENT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9.]+)+")
_WITHIN = re.compile(r"(?<![\w./=-])[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)+(?![\w/=-])(?!\.\w)")
"""A name within a sentence; not a part of a path, of a key path, or of an override."""
# Endings of names that repeat the unit -> the unit, longest first.
_ENDINGS = {
    "_k_per_min": "K/min", "_mw2_s": "mW² s", "_per_min": "1/min", "_w_m2": "W/m²", "_k_s": "K/s", "_v_k": "V/K",
    "_nats": "nats", "_percent": "%", "_ohm": "Ω", "_c_rate": "C", "_wh": "Wh", "_ah": "Ah", "_hz": "Hz",
    "_w2": "W²", "_mw": "mW", "_ms": "ms", "_us": "µs", "_s": "s", "_v": "V", "_a": "A", "_w": "W", "_k": "K",
    "_c": "°C", "_j": "J", "_h": "h",
}  # fmt: skip
_WORDS = {
    "soc": "SOC", "ise": "ISE", "mse": "MSE", "anfis": "ANFIS", "grnn": "GRNN", "cv": "CV", "cc": "CC", "dt": "dt",
    "w": "W", "pid": "PID", "ga": "GA", "rbf": "RBF", "c1": "C1", "c2": "C2", "p": "p", "r": "r",
    "reflex": "Reflex", "lyapunov": "Lyapunov", "hz": "Hz",
}  # fmt: skip


def number(value: Any, digits: int = DIGITS) -> str:
    """Return a cell for people: numbers to a few digits with a true minus sign, nothing as a dash."""
    cell = plain(value)
    if cell is None or cell == "":
        return NOTHING
    if isinstance(cell, str):
        return cell
    if isinstance(cell, int) or cell == 0.0:
        return _signed(f"{cell:.0f}")
    size = math.floor(math.log10(abs(cell)) + 1e-12)
    if -4 <= size < 9:
        places = max(digits - 1 - size, 0)
        text = f"{cell:.{places}f}"
        return _signed(text.rstrip("0").rstrip(".") if "." in text else text)
    mantissa, _, exponent = f"{cell:.{min(digits, 3) - 1}e}".partition("e")
    return _signed(f"{mantissa.rstrip('0').rstrip('.')} × 10") + str(int(exponent)).translate(_EXPONENT)


def _signed(text: str) -> str:
    return "0" if text == "-0" else text.replace("-", "−")


class Printed(NamedTuple):
    """A cell as it is printed: its text, and digits that take their room unseen behind it."""

    text: str
    room: str = ""
    numeric: bool = False


def column(cells: Sequence[Cell]) -> list[Printed]:
    """Return the cells of a column of a table with room behind them, so that their decimal points stand in one line.

    A number that is nothing beside the largest of its column is what rounding left over, and is shown as about 0.
    """
    sizes = [abs(cell) for cell in cells if isinstance(cell, (int, float)) and math.isfinite(cell)]
    floor = ROUNDING * max(sizes, default=0.0)
    printed = []
    for cell in map(plain, cells):
        left_over = isinstance(cell, float) and 0.0 < abs(cell) < floor
        printed.append(Printed("≈ 0" if left_over else number(cell), "", not isinstance(cell, str)))
    widest = "." + "0" * (max((len(_tail(one.text)) for one in printed if one.numeric), default=0) - 1)
    widest = widest if len(widest) > 1 else ""
    return [one._replace(room=widest[len(_tail(one.text)) :] if _has_room(one) else "") for one in printed]


def _tail(text: str) -> str:
    """Return the decimal point of a number and what is behind it."""
    return "" if "×" in text or "." not in text else text[text.index(".") :]


def _has_room(cell: Printed) -> bool:
    return cell.numeric and "×" not in cell.text


def unit(symbol: str) -> str:
    """Return a unit as it is printed; a pure number has none."""
    return "" if symbol == "1" else symbols(symbol)


def prose(text: str) -> str:
    """Return a sentence with its units as they are printed."""
    return symbols(text).replace(" +- ", " ± ").replace("+-", "±")


def symbols(text: str) -> str:
    """Return a text with the signs of its units."""
    text = re.sub(r"\bdegC\b", "°C", re.sub(r"\bohm\b", "Ω", text))
    text = re.sub(r"(?<=\w)\^([23])\b", lambda found: {"2": "²", "3": "³"}[found[1]], text)
    return re.sub(r"\b(m|mW|C-rate)([23])\b", lambda found: found[1] + {"2": "²", "3": "³"}[found[2]], text)


def share(value: Any) -> str:
    """Return a share as a percentage."""
    cell = plain(value)
    return f"{100 * float(cell):.0f} %" if cell is not None else NOTHING


def words(name: str) -> str:
    """Return an identifier as words."""
    return " ".join(_WORDS.get(word, word) for word in name.split("_"))


def label(cell: Any, with_unit: bool = True) -> str:
    """Return the name of a quantity as words with its unit; any other text as it is.

    Arguments
    ---------
    with_unit : whether the unit is to stand behind the words; not where another column has it.
    """
    text = number(cell)
    if not isinstance(cell, str) or not _NAME.fullmatch(cell):
        return _WORDS.get(text, text)
    for ending, symbol in _ENDINGS.items():
        if cell.endswith(ending) and cell != ending:
            told = words(cell.removesuffix(ending))
            return _capital(f"{told} [{symbol}]" if with_unit else told)
    return _capital(words(cell))


def spelt(text: str) -> str:
    """Return a sentence with the names of quantities in it as words, without the endings that repeat their units."""

    def told(found: re.Match[str]) -> str:
        name = found[0]
        ending = next(filter(name.endswith, _ENDINGS), "")
        return words(name.removesuffix(ending))

    return re.sub(r"(?<=[\d)]) x (?=[\w(])", " × ", _WITHIN.sub(told, text))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
