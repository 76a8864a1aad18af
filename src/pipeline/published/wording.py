"""Numbers and operands as a reader would say them."""

from __future__ import annotations

import math
import re

from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value

_UNIT_ENDING = re.compile(r"_(s|k|c|a|v|w|ah|wh|j|w_m2)$")


def plain(value: float, unit: str = "1") -> str:
    """Return a number to five digits with its unit; an infinite time reads `never`."""
    if math.isinf(value):
        return "never" if unit == "s" and value > 0 else "without bound"
    text = f"{value:.5g}" if abs(value) < 1e5 else f"{value:.0f}"
    return text if unit in ("1", "") else f"{text} {unit}"


def charge_name(artefact: str) -> str:
    """Return `mode (comparison)` for a charge, the input's own name for anything else."""
    parts = artefact.split("/")
    return f"{parts[2]} ({parts[1]})" if parts[0] == "charge" and len(parts) == 3 else artefact


def quantity_name(quantity: str) -> str:
    """Return a quantity's name as words, without its unit."""
    return _UNIT_ENDING.sub("", quantity).replace("_", " ").replace("soc", "SOC")


def label(operand: Operand) -> str:
    """Return an operand as words."""
    match operand:
        case Value():
            return f"{quantity_name(operand.quantity)} of {charge_name(operand.artefact)}"
        case Difference(difference=(left, right)):
            return f"({label(left)}) - ({label(right)})"
        case Ratio(ratio=(left, right)):
            return f"({label(left)}) / ({label(right)})"
        case Product(product=factors):
            return " x ".join(label(factor) for factor in factors)
        case Total(total=column):
            return f"sum of {label(column)}"
        case AtTime(at_time=moment):
            return f"{label(moment.value)} at {label(moment.time)}"
        case _:
            return plain(float(operand))


def stated(operand: Operand, value: float, unit: str) -> str:
    """Return an operand with its number, or the number alone where the operand is one."""
    return plain(value, unit) if isinstance(operand, (int, float)) else f"{label(operand)} is {plain(value, unit)}"
