"""What a predicate finds, and the numbers operands stand for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.published.artefacts import Reader, Unanswerable
from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value
from pipeline.published.wording import label


@dataclass(frozen=True)
class Outcome:
    """Whether a predicate holds, by how much, and the numbers behind it.

    `margin` is the distance to the point where it flips, in the statement's unit, negative where it fails;
    `share` is the same over what was allowed, a pure number.
    """

    holds: bool
    margin: float
    share: float
    sentence: str
    computed: float | None = None
    published: float | None = None
    tolerance: float | None = None


def number(operand: Operand, reader: Reader) -> float:
    """Return the number an operand stands for.

    Raises
    ------
    Unanswerable : an input is not part of the run, or a value is empty or not a number.
    """
    result = _number(operand, reader)
    if math.isnan(result):
        raise Unanswerable(f"{label(operand)} is not a number")
    return result


def _number(operand: Operand, reader: Reader) -> float:
    match operand:
        case Value():
            return reader.number(operand)
        case Difference(difference=(left, right)):
            return number(left, reader) - number(right, reader)
        case Ratio(ratio=(left, right)):
            divisor = number(right, reader)
            return number(left, reader) / divisor if divisor else math.nan
        case Product(product=factors):
            return math.prod(number(factor, reader) for factor in factors)
        case Total(total=column):
            found = reader.column(column)
            return float(np.sum(found)) if len(found) else math.nan
        case AtTime(at_time=moment):
            time = number(moment.time, reader)
            if math.isinf(time):
                raise Unanswerable(f"{label(moment.time)}: the charge did not get there")
            return float(np.interp(time, *reader.series(moment.value)))
        case _:
            return float(operand)
