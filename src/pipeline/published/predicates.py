"""The predicates: each a few lines from its record and the artefacts to an outcome."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.errors import UserError
from pipeline.published.artefacts import Columns, Reader, Unanswerable
from pipeline.published.operands import AtTime, Difference, Operand, Product, Ratio, Total, Value
from pipeline.published.records import (
    AllOf,
    Check,
    Close,
    CloseTo,
    Extreme,
    Greater,
    Largest,
    Less,
    Ordered,
    Range,
    Smallest,
    TableEquals,
    TablePair,
    Within,
)
from pipeline.published.wording import Wording, plain


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


def apply(check: Check, reader: Reader, unit: str) -> Outcome:
    """Return what a predicate finds.

    Arguments
    ---------
    check : the predicate.
    reader : the artefacts.
    unit : unit of the values compared, for the sentence, where no table declares it.

    Raises
    ------
    Unanswerable : a value it needs is not there.
    """
    told = Wording(reader, unit)
    match check:
        case Close(close=limits):
            return _close(limits, reader, told)
        case Less(less=pair):
            return _ordered(pair, reader, told, -1)
        case Greater(greater=pair):
            return _ordered(pair, reader, told, 1)
        case Smallest(smallest=extreme):
            return _extreme(extreme, reader, told, -1)
        case Largest(largest=extreme):
            return _extreme(extreme, reader, told, 1)
        case Within(within=limits):
            return _within(limits, reader, told)
        case TableEquals(table_equals=pair):
            return _table_equals(pair, reader, unit)
        case AllOf(all=parts):
            return _all([apply(part, reader, unit) for part in parts])
    raise TypeError(f"no predicate: {check!r}")


def number(operand: Operand, reader: Reader) -> float:
    """Return the number an operand stands for.

    Raises
    ------
    Unanswerable : an input is not part of the run, or a value is empty or not a number.
    """
    result = _number(operand, reader)
    if math.isnan(result):
        raise Unanswerable(f"{_label(operand, reader)} is not a number")
    return result


def _number(operand: Operand, reader: Reader) -> float:
    held = reader.held(operand)
    if held is not None:
        return held
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
                raise Unanswerable(f"{_label(moment.time, reader)}: the charge did not reach it")
            return float(np.interp(time, *reader.series(moment.value)))
        case _:
            return float(operand)


def _close(limits: CloseTo, reader: Reader, told: Wording) -> Outcome:
    value, target = number(limits.value, reader), number(limits.to, reader)
    allowed = limits.tolerance if limits.tolerance is not None else abs(target) * (limits.relative_tolerance or 0.0)
    margin = _known(allowed - abs(value - target), limits.value, reader)
    operands, unit = (limits.value, limits.to), told.unit((limits.value, limits.to))
    if isinstance(limits.to, float):
        required = f"{told.compared(operands[:1], (value,))}; required: {plain(target, unit)}, "
    else:
        required = f"{told.compared(operands, (value, target))}; "
    sentence = f"{required}tolerance ±{plain(allowed, unit)}"
    return Outcome(margin >= 0, margin, _share(margin, allowed), sentence, value, target, allowed)


def _ordered(pair: Ordered, reader: Reader, told: Wording, sign: int) -> Outcome:
    value, bound = number(pair.value, reader), number(pair.than, reader)
    margin = _known(sign * (value - bound) - pair.by, pair.value, reader)
    operands, than = (pair.value, pair.than), ">" if sign > 0 else "<"
    unit = told.unit(operands)
    if isinstance(pair.than, float):
        required = f"{told.compared(operands[:1], (value,))}; required: {than} {plain(bound, unit)}"
    else:
        required = f"{told.compared(operands, (value, bound))}; required: {f' {than} '.join(told.names(operands))}"
    sentence = required + _least(pair.by, sign * (value - bound), unit)
    published = bound if isinstance(pair.than, float) else None
    return Outcome(margin > 0, margin, _share(margin, bound), sentence, value, published)


def _extreme(extreme: Extreme, reader: Reader, told: Wording, sign: int) -> Outcome:
    value = number(extreme.value, reader)
    others = [number(other, reader) for other in extreme.among]
    ahead = min(sign * (value - other) for other in others)
    margin = _known(ahead - extreme.by, extreme.value, reader)
    operands = (extreme.value, *extreme.among)
    required = f"{told.names(operands)[0]} {'largest' if sign > 0 else 'smallest'}"
    least = _least(extreme.by, ahead, told.unit(operands))
    sentence = f"{told.compared(operands, (value, *others))}; required: {required}{least}"
    return Outcome(margin > 0, margin, _share(margin, value), sentence, value)


def _least(by: float, found: float, unit: str) -> str:
    """Return the margin that is required and the one found, where one is required."""
    return f" by at least {plain(by, unit)}; found {plain(found, unit)}" if by else ""


def _within(limits: Range, reader: Reader, told: Wording) -> Outcome:
    value = number(limits.value, reader)
    margin = _known(min(value - limits.low, limits.high - value), limits.value, reader)
    low, high = (plain(end, told.unit((limits.value,))) for end in (limits.low, limits.high))
    sentence = f"{told.compared((limits.value,), (value,))}; required: {low} to {high}"
    return Outcome(margin >= 0, margin, _share(margin, (limits.high - limits.low) / 2), sentence, value)


def _table_equals(pair: TablePair, reader: Reader, unit: str) -> Outcome:
    printed, found = (reader.table(*name.rsplit(".", 1)) for name in (pair.published, pair.computed))
    rows = _matching(pair, printed, found)
    worst, where = 0.0, ""
    for ours, theirs in pair.columns.items():
        distances = np.abs(np.asarray(printed[ours], float) - np.asarray(found[theirs], float)[rows])
        if np.isnan(distances).any():
            raise Unanswerable(f"column {ours} of {pair.published} or {theirs} of {pair.computed} has an empty cell")
        if distances.max() >= worst:
            worst = float(distances.max())
            where = f"column {ours}, row {int(distances.argmax()) + 1}"
    margin = pair.tolerance - worst
    cells = len(rows) * len(pair.columns)
    largest = f"largest deviation of {cells} cells: {plain(worst, unit)} ({where})"
    sentence = f"{largest}; tolerance ±{plain(pair.tolerance, unit)}"
    return Outcome(margin >= 0, margin, _share(margin, pair.tolerance), sentence, tolerance=pair.tolerance)


def _matching(pair: TablePair, printed: Columns, found: Columns) -> list[int]:
    for name, table, columns in (
        (pair.published, printed, (*pair.by, *pair.columns)),
        (pair.computed, found, (*pair.by, *pair.columns.values())),
    ):
        unknown = [column for column in columns if column not in table]
        if unknown:
            raise UserError(f"{name} has no column {unknown[0]!r}; known are: {', '.join(table)}")
    keys = {key: row for row, key in enumerate(zip(*(found[name].tolist() for name in pair.by), strict=True))}
    wanted = list(zip(*(printed[name].tolist() for name in pair.by), strict=True))
    lost = [key for key in wanted if key not in keys]
    if lost or not wanted:
        raise Unanswerable(f"{pair.computed} has no row for {', '.join(pair.by)} = {lost[0] if lost else 'any'}")
    return [keys[key] for key in wanted]


def _all(parts: list[Outcome]) -> Outcome:
    share = min(part.share for part in parts)
    return Outcome(all(part.holds for part in parts), share, share, "; ".join(part.sentence for part in parts))


def _known(margin: float, operand: Operand, reader: Reader) -> float:
    if math.isnan(margin):
        raise Unanswerable(f"{_label(operand, reader)}: neither this nor what it is compared with was reached")
    return margin


def _label(operand: Operand, reader: Reader) -> str:
    return Wording(reader, "1").label(operand)


def _share(margin: float, allowed: float) -> float:
    return margin / abs(allowed) if allowed and not math.isinf(allowed) else margin
