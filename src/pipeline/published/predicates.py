"""The predicates: each a few lines from its record and the artefacts to an outcome."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.errors import UserError
from pipeline.kernel.experiment import kind_of
from pipeline.published.artefacts import Columns, Reader, Unanswerable, number
from pipeline.published.operands import Operand, Value, values
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
    Told,
    Within,
    compared,
)
from pipeline.published.reference import PRINTED
from pipeline.published.wording import SAME, Wording, exact, of_differences, opened, plain


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


def apply(check: Check, reader: Reader, unit: str, called: Mapping[str, str] | None = None) -> Outcome:
    """Return what a predicate finds.

    Arguments
    ---------
    check : the predicate.
    reader : the artefacts.
    unit : unit of the values compared, for the sentence, where no table declares it.
    called : what quantities, modes and comparisons are called, as `Wording` takes it.

    Raises
    ------
    Unanswerable : a value it needs is not there.
    """
    told = Wording(reader, unit, called)
    try:
        return _apply(check, reader, told, unit, called or {})
    except Unanswerable as lack:
        raise type(lack)(told.reason(lack)) from None


def _apply(check: Check, reader: Reader, told: Wording, unit: str, called: Mapping[str, str]) -> Outcome:
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
            shared = _shared_row(parts)
            inner = told if shared is None else Wording(reader, unit, called, shared.where)
            found = [_apply(part, reader, inner, unit, called) for part in parts]
            return _all(found, "" if shared is None else told.row(shared, shared.where))
    raise TypeError(f"no predicate: {check!r}")


def _close(limits: CloseTo, reader: Reader, told: Wording) -> Outcome:
    value, target = number(limits.value, reader), number(limits.to, reader)
    allowed = limits.tolerance if limits.tolerance is not None else abs(target) * (limits.relative_tolerance or 0.0)
    margin = _known(allowed - abs(value - target), limits.value)
    operands, unit, apart = (limits.value, limits.to), told.unit((limits.value, limits.to)), abs(value - target)
    counted = allowed < 1.0 and unit == "1" and value == round(value) and target == round(target)
    if isinstance(limits.to, float) or _is_printed(limits.to):
        asked = told.compared(operands[:1], (value,), limits, min(apart, abs(margin)))
        width = "" if counted else f"{exact(target)} ± {exact(allowed, unit)}"
        printed = ", as printed" if _is_printed(limits.to) else ""
        sentence = f"{asked}; required: {width or exact(target, unit)}{printed}"
    else:
        within = f"required: equal within {exact(allowed, of_differences(unit))}"
        found = f"found {plain(apart, of_differences(unit))} apart"
        required = "required: equal" if counted else f"{within}; {found}"
        sentence = f"{told.compared(operands, (value, target), limits, apart)}; {required}"
    return Outcome(margin >= 0, margin, _share(margin, allowed), sentence, value, target, allowed)


def _is_printed(operand: Operand) -> bool:
    """Tell whether an operand is a number of the paper, so that it counts as the one that is required."""
    return isinstance(operand, Value) and kind_of(operand.artefact) == PRINTED


def _ordered(pair: Ordered, reader: Reader, told: Wording, side: int) -> Outcome:
    value, bound = number(pair.value, reader), number(pair.than, reader)
    ahead = side * (value - bound)
    margin = _known(ahead - pair.by, pair.value)
    operands, than = (pair.value, pair.than), ">" if side > 0 else "<"
    unit = told.unit(operands)
    given = 1 if isinstance(pair.than, float) else 2
    asked = told.compared(operands[:given], (value, bound)[:given], pair, abs(ahead))
    if isinstance(pair.than, float):
        required = f"{than} {exact(bound + side * pair.by, unit)}"
    elif names := told.names(operands, pair):
        required = f"{names[0]} {than} {names[1]}{_least(pair.by, ahead, unit)}"
    else:
        required = f"the first {'larger' if side > 0 else 'smaller'}{_least(pair.by, ahead, unit)}"
    published = bound if isinstance(pair.than, float) else None
    return Outcome(margin > 0, margin, _share(margin, bound), f"{asked}; required: {required}", value, published)


def _extreme(extreme: Extreme, reader: Reader, told: Wording, side: int) -> Outcome:
    value = number(extreme.value, reader)
    others = [number(other, reader) for other in extreme.among]
    ahead = min(side * (value - other) for other in others)
    margin = _known(ahead - extreme.by, extreme.value)
    operands = (extreme.value, *extreme.among)
    first = next(iter(told.names(operands, extreme)), "the first")
    required = f"{first} {'largest' if side > 0 else 'smallest'}{_least(extreme.by, ahead, told.unit(operands))}"
    asked = told.compared(operands, (value, *others), extreme, abs(ahead))
    return Outcome(margin > 0, margin, _share(margin, value), f"{asked}; required: {required}", value)


def _least(by: float, found: float, unit: str) -> str:
    """Return the margin that is required and the one found, where one is required."""
    unit = of_differences(unit)
    return f" by at least {exact(by, unit)}; found {plain(found, unit)}" if by else ""


def _within(limits: Range, reader: Reader, told: Wording) -> Outcome:
    value = number(limits.value, reader)
    margin = _known(min(value - limits.low, limits.high - value), limits.value)
    asked = told.compared((limits.value,), (value,), limits, abs(margin))
    sentence = f"{asked}; required: {exact(limits.low)} to {exact(limits.high, told.unit((limits.value,)))}"
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
    allowed = f"tolerance ±{exact(pair.tolerance, unit)}"
    sentence = f"all {cells} cells agree; {allowed}"
    if worst > SAME * pair.tolerance:
        sentence = f"largest deviation of {cells} cells: {plain(worst, unit)} ({where}); {allowed}"
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


def _parts(checks: tuple[Check, ...]) -> Iterator[Operand]:
    """Yield what the parts of a predicate compare."""
    for check in checks:
        for name in type(check).model_fields:
            part = getattr(check, name)
            yield from _parts(part) if isinstance(part, tuple) else compared(part) if isinstance(part, Told) else ()


def _shared_row(parts: tuple[Check, ...]) -> Value | None:
    """Return a value of the row that all values of several predicates share, a paper's own apart."""
    found = [one for operand in _parts(parts) for one in values(operand) if kind_of(one.artefact) != PRINTED]
    same = found and all(one.where == found[0].where and one.artefact == found[0].artefact for one in found)
    return found[0] if same and found[0].where else None


def _all(parts: list[Outcome], where: str) -> Outcome:
    """Return the outcome of several predicates, a sentence each; what they share of their rows is told first."""
    share = min(part.share for part in parts)
    told = ". ".join(opened(part.sentence) for part in parts)
    sentence = f"{opened(where)}. {told}" if where else told
    return Outcome(all(part.holds for part in parts), share, share, sentence)


def _known(margin: float, operand: Operand) -> float:
    if math.isnan(margin):
        raise Unanswerable("was not reached, and neither was what it is compared with", operand)
    return margin


def _share(margin: float, allowed: float) -> float:
    return margin / abs(allowed) if allowed and not math.isinf(allowed) else margin
