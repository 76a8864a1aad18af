"""The answer of a study: what to take, by how much it is better, in what, and how sure that is; from quantities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from pydantic import Field

from pipeline.kernel.tables import Column, Table
from pipeline.published.artefacts import Impossible, Lookup, Sample, Unanswerable, number
from pipeline.published.operands import Operand, atoms, text
from pipeline.published.wording import exact, of_differences, opened, plain
from pipeline.published.words import ENOUGH, PARAMETERS, Robust
from pipeline.record import Record


class Choice(Record):
    """One thing in which the alternatives of a study are held against each other."""

    of: str = Field(min_length=1, description="what is compared, and under which condition")
    better: Literal["less", "greater"] = Field(description="which of two numbers is the better one")
    by: float = Field(gt=0, le=1e6, description="least difference that matters [unit]")
    unit: str = Field(description="unit of the numbers")
    among: dict[str, Operand] = Field(min_length=2, description="alternative, for people -> its number")


ANSWER = Table(
    "answer",
    "What the study recommends, sentence by sentence; the first sums up the others",
    (
        Column("question", "", "identifier of what is compared; empty for the sum", "text"),
        Column("best", "", "the best alternative; empty where none is surely better by what matters", "text"),
        Column("sentence", "", "the answer in words", "text"),
        Column("lead", "see the sentence", "by how much the best is ahead of the next", optional=True),
        Column("share", "1", "share of the points in which it leads by what matters", optional=True),
        Column("low", "1", "lower end of the 95 % interval of that share", optional=True),
        Column("high", "1", "upper end of it", optional=True),
    ),
)


class _Found(NamedTuple):
    best: str
    next: str
    lead: float
    robust: Robust | None
    values: Mapping[str, float]
    sure: bool


def answered(choices: Mapping[str, Choice], artefacts: Lookup, samples: Sequence[Sample]) -> dict[str, list[Any]]:
    """Return the columns of the answer: a sentence that sums up, then one for each thing compared.

    Arguments
    ---------
    choices : identifier -> what is compared.
    artefacts : what this run made.
    samples : the points of the ensembles.
    """
    found: dict[str, _Found] = {}
    rows: list[tuple[Any, ...]] = []
    for name, choice in choices.items():
        try:
            one = _compared(choice, artefacts, samples)
        except Unanswerable as reason:
            rows.append((name, "", f"{opened(choice.of)}: no answer, since {reason}.", None, None, None, None))
            continue
        found[name] = one
        interval = (None, None) if one.robust is None else one.robust.interval()
        share = None if one.robust is None else one.robust.share
        rows.append((name, one.best if one.sure else "", _sentence(choice, one), one.lead, share, *interval))
    if found:
        rows.insert(0, ("", *_sum(choices, found), None, None, None, None))
    return {column.name: [row[place] for row in rows] for place, column in enumerate(ANSWER.columns)}


def _compared(choice: Choice, artefacts: Lookup, samples: Sequence[Sample]) -> _Found:
    values = {name: number(operand, artefacts) for name, operand in choice.among.items()}
    best, second = _order(choice, values)[:2]
    lead = abs(values[best] - values[second])
    robust = _leads(choice, best, samples)
    share, of = ENOUGH
    sure = robust is None or of * robust.held >= share * robust.counted
    return _Found(best, second, lead, robust, values, sure and lead >= choice.by)


def _order(choice: Choice, values: Mapping[str, float]) -> list[str]:
    return sorted(values, key=lambda name: values[name], reverse=choice.better == "greater")


def _leads(choice: Choice, best: str, samples: Sequence[Sample]) -> Robust | None:
    """Return in how many points the best is ahead of every other by what matters; none where no ensemble says."""
    read = {text(one) for operand in choice.among.values() for one in atoms(operand)}
    own = [sample for sample in samples if sample.of == PARAMETERS and read & set(sample.numbers)]
    varying = {name for sample in own for name in read & set(sample.numbers)}
    held = counted = left_out = 0
    for sample in (one for one in own if varying <= set(one.numbers)):
        try:
            values = {name: number(operand, sample) for name, operand in choice.among.items()}
        except Impossible:
            left_out += 1
            continue
        except Unanswerable:
            counted += 1
            continue
        first, second = _order(choice, values)[:2]
        counted += 1
        held += first == best and abs(values[first] - values[second]) >= choice.by
    return Robust(held, counted, left_out) if counted else None


def _sentence(choice: Choice, found: _Found) -> str:
    values = found.values.items()
    apart = max(found.lead, choice.by)
    listed = ", ".join(f"{name} {plain(value, choice.unit, apart)}" for name, value in values)
    leads = f"Ahead: {found.best}, {_by(choice, found.lead)}"
    points = ""
    if found.robust is not None:
        low, high = found.robust.interval()
        matters = f"{choice.by:g} {of_differences(choice.unit)}".removesuffix(" 1")
        points = (
            f"; by {matters} or more at {found.robust.held} of {found.robust.counted} points of the estimated "
            f"parameters ({100 * low:.0f} to {100 * high:.0f} %)"
        )
    clear = "" if found.sure else ", so no clear difference"
    return f"{opened(choice.of)}: {listed}. {leads}{points}{clear}."


def _by(choice: Choice, lead: float) -> str:
    """Return by how much one is ahead, no finer than a tenth of what matters."""
    unit, finest = of_differences(choice.unit), choice.by / 10.0
    if lead < finest:
        return f"by less than {exact(finest, unit)}"
    step = 10.0 ** math.floor(math.log10(finest))
    return f"by {exact(round(lead / step) * step, unit) if lead < 1000.0 * step else plain(lead, unit)}"


def _sum(choices: Mapping[str, Choice], found: Mapping[str, _Found]) -> tuple[str, str]:
    """Return the alternative that is nowhere surely outdone, and the sentence that sums up."""
    sure = {name: one.best for name, one in found.items() if one.sure}
    open_ = [choices[name].of for name in found if name not in sure]
    rest = f" No clear difference in {' or '.join(open_)}." if open_ else ""
    if not sure:
        return "", "No alternative is clearly better." + rest
    winners = list(dict.fromkeys(sure.values()))
    if len(winners) == 1:
        told = " and ".join(f"{_by(choices[name], found[name].lead)} in {choices[name].of}" for name in sure)
        return winners[0], f"Best: {winners[0]}, {told}.{rest}"
    of = {who: " and ".join(choices[name].of for name, one in sure.items() if one == who) for who in winners}
    return "", f"It depends on what counts: {'; '.join(f'{who} for {what}' for who, what in of.items())}.{rest}"
