"""Numbers and operands as a reader would say them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value, values

_UNITS = {
    "s": "s", "k": "K", "c": "degC", "a": "A", "v": "V", "w": "W", "j": "J", "ah": "Ah", "wh": "Wh", "hz": "Hz",
    "k_s": "K/s", "mw2_s": "mW2 s", "nats": "nat",
}  # fmt: skip
_UNIT_ENDING = re.compile(rf"_({'|'.join(_UNITS)})$")
# Not watt but the inertia weight W, a factor of a parameter design.
_WEIGHT = re.compile(r"_(chosen|best|p)_w$")


def plain(value: float, unit: str = "1") -> str:
    """Return a number to five digits with its unit; an infinite time reads `never`."""
    if math.isinf(value):
        return "never" if unit == "s" and value > 0 else "without bound"
    text = f"{value:.5g}" if abs(value) < 1e5 else f"{value:.0f}"
    return text if unit in ("1", "") else f"{text} {unit}"


def charge_name(artefact: str) -> str:
    """Return `mode (comparison)` for a charge, the input's own name for anything else."""
    parts = artefact.split("/")
    return f"{parts[2]} ({parts[1].replace('_', ' ')})" if parts[0] == "charge" and len(parts) == 3 else artefact


def quantity_name(quantity: str) -> str:
    """Return a quantity's name as words, without its unit."""
    kept = quantity if _WEIGHT.search(quantity) else _UNIT_ENDING.sub("", quantity)
    return kept.replace("_", " ").replace("soc", "SOC")


def unit_of(operand: Operand, unit: str) -> str:
    """Return the unit a value's name carries, else the statement's."""
    if not isinstance(operand, Value) or _WEIGHT.search(operand.quantity):
        return unit
    found = _UNIT_ENDING.search(operand.quantity)
    return _UNITS[found[1]] if found else unit


def shape(operand: Operand) -> str:
    """Return an operand as words, without saying of which artefact."""
    match operand:
        case Value():
            return quantity_name(operand.quantity)
        case Difference(difference=(left, right)):
            return f"{_part(left)} - {_part(right)}"
        case Ratio(ratio=(left, right)):
            if len({value.artefact for value in values(operand)}) > 1:
                return f"{label(left)} / {label(right)}"
            return f"{_part(left)} / {_part(right)}"
        case Product(product=factors):
            return " x ".join(_part(factor) for factor in factors)
        case Total(total=column):
            return f"sum of {shape(column)}"
        case AtTime(at_time=moment):
            return f"{label(moment.value)} at {label(moment.time)}"
        case _:
            return plain(float(operand))


def _part(operand: Operand) -> str:
    text = shape(operand)
    return f"({text})" if isinstance(operand, (Difference, Ratio)) else text


def label(operand: Operand) -> str:
    """Return an operand as words with its artefact."""
    owners = {value.artefact for value in values(operand)} if not isinstance(operand, float) else set()
    if len(owners) != 1 or isinstance(operand, AtTime):
        return shape(operand)
    owner = owners.pop()
    return (
        f"printed {shape(operand)}" if owner.startswith("reference/") else f"{shape(operand)} of {charge_name(owner)}"
    )


def stated(operand: Operand, value: float, unit: str) -> str:
    """Return an operand with its number, or the number alone where the operand is one or is printed."""
    text = plain(value, unit_of(operand, unit))
    if isinstance(operand, float):
        return text
    if not values(operand):
        return f"{shape(operand)} = {text}"
    printed = isinstance(operand, Value) and operand.artefact.startswith("reference/")
    return f"printed {text}" if printed else f"{label(operand)} {text}"


def compared(operands: Sequence[Operand], found: Sequence[float], unit: str) -> str:
    """Return operands that differ only in their artefact with their numbers, what they are said once; else nothing."""
    owners = [{value.artefact for value in values(one)} if not isinstance(one, float) else set() for one in operands]
    if len({shape(one) for one in operands}) > 1 or any(len(owner) != 1 for owner in owners):
        return ""
    numbers = (plain(value, unit_of(one, unit)) for one, value in zip(operands, found, strict=True))
    names = _rows(operands) or [charge_name(owner.pop()) for owner in owners]
    told = (f"{name} {number}" for name, number in zip(names, numbers, strict=True))
    return f"{shape(operands[0])}: {', '.join(told)}"


def _rows(operands: Sequence[Operand]) -> list[str]:
    """Return the rows of values of one table by what tells them apart; nothing where another table is among them."""
    rows = [one.where for one in operands if isinstance(one, Value) and one.where]
    if len(rows) < len(operands) or len({one.artefact for one in operands if isinstance(one, Value)}) > 1:
        return []
    told = [[f"{name} {row[name]:g}" if isinstance(row[name], float) else f"{name} {row[name]}"
             for name in row if len({str(other.get(name)) for other in rows}) > 1] for row in rows]  # fmt: skip
    return [", ".join(words) for words in told] if all(told) else []
