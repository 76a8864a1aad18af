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
LINE = 88
"""Characters above which a command stands on several lines."""
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
    "reflex": "Reflex", "lyapunov": "Lyapunov", "hz": "Hz", "takagi": "Takagi", "sugeno": "Sugeno",
}  # fmt: skip
# Cells that say a thing by a name of the code's own -> what people call it.
_PHRASES = {
    "end_reason": "ended by", "missed": "goal not reached", "steps": "steps of integration", "edges": "edges of pulses",
    "electrical": "electrical energy", "chemical": "chemical energy", "sensible": "warming of the battery",
    "ambient": "given off to the surroundings", "iterations_to_within_1_hz": "iterations to within 1 Hz",
}  # fmt: skip
_PAIR = re.compile(r"pair[ _](\w+?)([ _]store)?")
_ENDED = re.compile(
    r"(stop: )?(elapsed|soc|voltage below its peak by|voltage|current|temperature rate|temperature) ([\d.e+-]+)( \S+)?"
)
_LIMITS = {
    "elapsed": "time limit of {}", "soc": "SOC {}", "voltage below its peak by": "voltage {} below its peak",
    "temperature rate": "temperature rate of {}",
}  # fmt: skip
_KNOB = re.compile(r"(?<![\w/.])(c1|c2|w(?= (?:had|explains|with)\b))(?![\w/.=])")
"""A knob of the swarm within a sentence, as its tables write it."""


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
        printed.append(Printed("≈ 0" if left_over else ended(number(cell)), "", not isinstance(cell, str)))
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
    text = re.sub(r"\b10\^(-?\d+)", lambda found: f"10{found[1].translate(_EXPONENT)}", symbols(text))
    text = re.sub(r"(?<=[\w)]) - (?=[\w(])", " − ", text)
    return times(text.replace(" +- ", " ± ").replace("+-", "±"))


def times(text: str) -> str:
    """Return a text with the sign of multiplication between its numbers."""
    return re.sub(r"(?<=[\d)]) x (?=[\d(])", " × ", text)


def ended(reason: str) -> str:
    """Return what ended a phase or a charge as a data sheet would say it; any other text as it is.

    Arguments
    ---------
    reason : as the engine writes it: `stop: soc 0.99`, `elapsed 3600 s`.
    """
    found = _ENDED.fullmatch(reason)
    if found is None:
        return reason
    stop, limit, value, symbol = found.groups(default="")
    amount = f"{100.0 * float(value):.6g} %" if limit == "soc" else f"{value}{symbols(symbol)}"
    if limit == "elapsed" and not stop:
        return f"{amount} over"
    return ("stop at " if stop else "") + _LIMITS.get(limit, f"{limit} of {{}}").format(amount)


def symbols(text: str) -> str:
    """Return a text with the signs of its units."""
    text = re.sub(r"\bdegC\b", "°C", re.sub(r"\bohm\b", "Ω", text))
    text = re.sub(r"(?<=\w)\^([23])\b", lambda found: {"2": "²", "3": "³"}[found[1]], text)
    return re.sub(r"\b(m|mW|C-rate)([23])\b", lambda found: found[1] + {"2": "²", "3": "³"}[found[2]], text)


def share(value: Any) -> str:
    """Return a share as a percentage."""
    cell = plain(value)
    return _signed(f"{100 * float(cell):.0f}") + " %" if cell is not None else NOTHING


def shell(command: str) -> str:
    """Return a command as a shell takes it; a long one has a line for each file and each option with its values.

    Arguments
    ---------
    command : in one line; what is quoted stays together.
    """
    if len(command) <= LINE:
        return command
    lines: list[str] = []
    for word in re.findall(r"(?:'[^']*'|\"[^\"]*\"|[^\s'\"])+", command):
        own_line = not lines or "/" in word or (word.startswith("--") and " " in lines[0])
        lines = [*lines, word] if own_line else [*lines[:-1], f"{lines[-1]} {word}"]
    return " \\\n  ".join(lines)


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
    if isinstance(cell, str) and (cell in _PHRASES or _PAIR.fullmatch(cell)):
        return _PHRASES.get(cell) or rc_pair(cell)
    if not isinstance(cell, str) or not _NAME.fullmatch(cell):
        return _WORDS.get(text, ended(text))
    cell = re.sub(r"_(\d+)_bins$", r",_\1_bins", cell)
    for ending, symbol in _ENDINGS.items():
        if cell.endswith(ending) and cell != ending:
            told = words(cell.removesuffix(ending))
            return _capital(f"{told} [{symbol}]" if with_unit else told)
    return _capital(words(cell))


def rc_pair(path: str) -> str:
    """Return what a path of the energy of an RC pair is called, `pair slow` or `pair slow store` say."""
    found = _PAIR.fullmatch(path)
    if found is None:
        return path
    return f"RC pair “{found[1].replace('_', ' ')}”{', energy it keeps' if found[2] else ''}"


def is_name(cell: Any) -> bool:
    """Tell whether a cell is a name of the code's own."""
    return isinstance(cell, str) and _NAME.fullmatch(cell) is not None


def spelt(text: str) -> str:
    """Return a sentence with the names of quantities in it as words, without the endings that repeat their units."""

    def told(found: re.Match[str]) -> str:
        name = found[0]
        ending = next(filter(name.endswith, _ENDINGS), "")
        return words(name.removesuffix(ending))

    text = _KNOB.sub(lambda found: found[1].upper(), _WITHIN.sub(told, text))
    return re.sub(r"(?<=[\d)]) x (?=[\w(])", " × ", text)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
