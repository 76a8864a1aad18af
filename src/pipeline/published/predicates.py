"""The predicates: each a few lines from its record and the artefacts to an outcome."""

from __future__ import annotations

import math

import numpy as np

from pipeline.errors import UserError
from pipeline.published.artefacts import Columns, Reader, Unanswerable
from pipeline.published.operands import Operand
from pipeline.published.outcome import Outcome, number
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
from pipeline.published.wording import compared, label, plain, stated, unit_of


def apply(check: Check, reader: Reader, unit: str) -> Outcome:
    """Return what a predicate finds.

    Arguments
    ---------
    check : the predicate.
    reader : the artefacts.
    unit : unit of the values compared, for the sentence.

    Raises
    ------
    Unanswerable : a value it needs is not there.
    """
    match check:
        case Close(close=limits):
            return _close(limits, reader, unit)
        case Less(less=pair):
            return _ordered(pair, reader, unit, -1)
        case Greater(greater=pair):
            return _ordered(pair, reader, unit, 1)
        case Smallest(smallest=extreme):
            return _extreme(extreme, reader, unit, -1)
        case Largest(largest=extreme):
            return _extreme(extreme, reader, unit, 1)
        case Within(within=limits):
            return _within(limits, reader, unit)
        case TableEquals(table_equals=pair):
            return _table_equals(pair, reader, unit)
        case AllOf(all=parts):
            return _all([apply(part, reader, unit) for part in parts])
    raise TypeError(f"no predicate: {check!r}")


def _close(limits: CloseTo, reader: Reader, unit: str) -> Outcome:
    value, target = number(limits.value, reader), number(limits.to, reader)
    allowed = limits.tolerance if limits.tolerance is not None else abs(target) * (limits.relative_tolerance or 0.0)
    margin = _known(allowed - abs(value - target), limits.value)
    within = plain(allowed, unit_of(limits.value, unit))
    told = compared((limits.value, limits.to), (value, target), unit)
    asked = f"{stated(limits.value, value, unit)}; asked to be within {within} of {stated(limits.to, target, unit)}"
    sentence = f"{told}; asked to agree to {within}" if told else asked
    return Outcome(margin >= 0, margin, _share(margin, allowed), sentence, value, target, allowed)


def _ordered(pair: Ordered, reader: Reader, unit: str, sign: int) -> Outcome:
    value, bound = number(pair.value, reader), number(pair.than, reader)
    margin = _known(sign * (value - bound) - pair.by, pair.value)
    word = "above" if sign > 0 else "below"
    least = f" by {plain(pair.by, unit)}" if pair.by else ""
    told = compared((pair.value, pair.than), (value, bound), unit)
    asked = f"{stated(pair.value, value, unit)}; asked to be {word} {stated(pair.than, bound, unit)}{least}"
    sentence = f"{told}; the first is asked to be {word} the second{least}" if told else asked
    published = bound if isinstance(pair.than, float) else None
    return Outcome(margin > 0, margin, _share(margin, bound), sentence, value, published)


def _extreme(extreme: Extreme, reader: Reader, unit: str, sign: int) -> Outcome:
    value = number(extreme.value, reader)
    others = [number(other, reader) for other in extreme.among]
    margin = _known(min(sign * (value - other) for other in others) - extreme.by, extreme.value)
    operands, found = (extreme.value, *extreme.among), (value, *others)
    told = compared(operands, found, unit) or ", ".join(
        stated(operand, one, unit) for operand, one in zip(operands, found, strict=True)
    )
    least = f" by {plain(extreme.by, unit)}" if extreme.by else ""
    sentence = f"{told}; the first is asked to be the {'largest' if sign > 0 else 'smallest'}{least}"
    return Outcome(margin > 0, margin, _share(margin, value), sentence, value)


def _within(limits: Range, reader: Reader, unit: str) -> Outcome:
    value = number(limits.value, reader)
    margin = _known(min(value - limits.low, limits.high - value), limits.value)
    asked = f"{plain(limits.low, unit)} to {plain(limits.high, unit)}"
    sentence = f"{stated(limits.value, value, unit)}; asked to lie in {asked}"
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
    sentence = (
        f"of {cells} cells the farthest apart is {plain(worst, unit)} ({where}); {plain(pair.tolerance, unit)} asked"
    )
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


def _known(margin: float, operand: Operand) -> float:
    if math.isnan(margin):
        raise Unanswerable(f"{label(operand)}: neither this nor what it is compared with was reached")
    return margin


def _share(margin: float, allowed: float) -> float:
    return margin / abs(allowed) if allowed and not math.isinf(allowed) else margin
