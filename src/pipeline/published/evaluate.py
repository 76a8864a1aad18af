"""From statements and artefacts to verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from pipeline.kernel.tables import Column, Table
from pipeline.published.artefacts import Impossible, Lookup, Sample, Unanswerable, number
from pipeline.published.operands import atoms, text
from pipeline.published.predicates import Outcome, apply
from pipeline.published.records import Size, Statement
from pipeline.published.wording import Wording, exact, opened
from pipeline.published.words import PARAMETERS, RESAMPLED, SEEDS, WORDS, Robust, word

VERDICTS = Table(
    "verdicts",
    "Every published statement that was examined, with its computed verdict",
    (
        Column("statement", "", "identifier of the statement", "text"),
        Column("where", "", "where it stands in the paper", "text"),
        Column("says", "", "what it says", "text"),
        Column("reading", "", "how the words became a predicate, and why this tolerance", "text"),
        Column("conditions", "", "what of the paper's conditions we could not keep", "text"),
        Column("basis", "", "paper_data, mathematics, model, search or none", "text"),
        Column("verdict", "", f"{', '.join(WORDS)}", "text"),
        Column("met", "", "yes or no: the predicate with the study's own values; empty where it has no answer", "text"),
        Column("published_value", "see unit", "the printed number, where there is one", optional=True),
        Column("computed_value", "see unit", "the number that answers it, where there is one", optional=True),
        Column("unit", "", "unit of both", "text"),
        Column("tolerance", "see unit", "how far the two may be apart", optional=True),
        Column(
            "margin",
            "see unit",
            "distance to the point where the verdict flips; negative where it failed",
            optional=True,
        ),
        Column(
            "robust_share",
            "1",
            "share of the points of estimates, or of seeds, where it is true",
            optional=True,
        ),
        Column("robust_low", "1", "lower end of the 95 % interval of that share", optional=True),
        Column("robust_high", "1", "upper end of it", optional=True),
        Column("robust_points", "1", "points that count", optional=True),
        Column("robust_left_out", "1", "points that no battery can have", optional=True),
        Column("explanation", "", "the numbers behind the verdict in a sentence", "text"),
    ),
)
COLUMNS = [column.name for column in VERDICTS.columns]


def evaluate(
    statements: Mapping[str, Statement],
    artefacts: Lookup,
    calibrated_to: Collection[str] = (),
    samples: Sequence[Sample] = (),
    called: Mapping[str, str] | None = None,
) -> dict[str, list[Any]]:
    """Return the columns of the table of verdicts, a row per statement in the order given.

    Arguments
    ---------
    statements : identifier -> statement.
    artefacts : what this run made.
    calibrated_to : identifiers of the statements that a parameter they depend on was calibrated to.
    samples : the points of the ensembles.
    called : what quantities, modes and comparisons are called in sentences.
    """
    rows = [
        _row(name, stated, artefacts, samples, name in calibrated_to, called or {})
        for name, stated in statements.items()
    ]
    return {column: [row[column] for row in rows] for column in COLUMNS}


def _row(
    name: str,
    stated: Statement,
    artefacts: Lookup,
    samples: Sequence[Sample],
    calibrated: bool,
    called: Mapping[str, str],
) -> dict[str, Any]:
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"statement": name, "met": ""}
    row |= stated.model_dump(include={"where", "says", "reading", "conditions", "basis", "unit"})
    if stated.check is None:
        return row | _without_a_check(stated, artefacts, called)
    try:
        outcome = apply(stated.check, artefacts, stated.unit, called)
        small = "" if stated.asks is None else _smaller(stated.asks, artefacts, called)
    except Unanswerable as reason:
        return row | {"verdict": "not checkable", "explanation": f"Missing: {reason}."}
    row["computed_value"] = _finite(outcome.computed)
    if small:
        return row | {"verdict": "not checkable", "explanation": _sentences(small, f"ours: {outcome.sentence}")}
    robust = _robust(stated, samples)
    return row | {
        "verdict": word(stated.basis, outcome.holds, robust, calibrated),
        "met": "yes" if outcome.holds else "no",
        "published_value": _finite(outcome.published) if stated.form == "number" else None,
        "tolerance": _finite(outcome.tolerance),
        "margin": _finite(outcome.margin),
        **_shares(robust),
        "explanation": _sentences(outcome.sentence, "" if robust is None else robust.sentence()),
    }


def _without_a_check(stated: Statement, artefacts: Lookup, called: Mapping[str, str]) -> dict[str, Any]:
    """Return what is missing, what would assess it, and what this run comes to all the same."""
    words = Wording(artefacts, stated.unit, called)
    told, found = [f"missing: {stated.missing.rstrip('.')}"], []
    if stated.assessed_by:
        told = [f"not assessed: {stated.missing.rstrip('.')}", f"it would take {stated.assessed_by.rstrip('.')}"]
    try:
        found = [number(one, artefacts) for one in stated.ours]
    except Unanswerable as reason:
        told.append(f"ours is missing too: {words.reason(reason)}")
    if found:
        told.append(f"ours: {words.compared(stated.ours, found)}")
    shown = _finite(found[0]) if found else None
    return {"verdict": "not checkable", "computed_value": shown, "explanation": _sentences(*told)}


def _smaller(size: Size, artefacts: Lookup, called: Mapping[str, str]) -> str:
    """Return in words that this run is smaller than the paper's experiment; nothing where it is not."""
    words = Wording(artefacts, "1", called)
    sizes = zip([artefacts.number(value) for value in size.ours], size.paper, size.ours, strict=True)
    fewer = [
        f"{exact(ours)} of the paper's {exact(paper)} {words.shape(one)}" for ours, paper, one in sizes if ours < paper
    ]
    return f"too small to tell: {', '.join(fewer)}" if fewer else ""


def _shares(robust: Robust | None) -> dict[str, float | None]:
    if robust is None:
        return {}
    low, high = robust.interval()
    return {
        "robust_share": robust.share,
        "robust_low": low,
        "robust_high": high,
        "robust_points": robust.counted,
        "robust_left_out": robust.left_out,
    }


def _robust(stated: Statement, samples: Sequence[Sample]) -> Robust | None:
    """Return in how many points a claim is true; none where no ensemble answers it.

    A claim of the model is asked in points of the estimated parameters, one of a search in experiments of other seeds.
    Points that lack something of what varies belong to an ensemble of more points than another.
    """
    kinds = {"model": (PARAMETERS,), "search": (SEEDS, RESAMPLED)}.get(stated.basis, ())
    asked = set() if stated.check is None else {text(one) for one in atoms(stated.check)}
    own = [sample for sample in samples if sample.of in kinds and not asked.isdisjoint(sample.numbers)]
    varying = {name for sample in own for name in asked.intersection(sample.numbers)}
    outcomes = [_attempt(stated, sample) for sample in own if varying <= set(sample.numbers)]
    possible = [outcome for outcome in outcomes if not isinstance(outcome, Impossible)]
    if not possible:
        return None
    held = sum(isinstance(outcome, Outcome) and outcome.holds for outcome in possible)
    silent = sum(isinstance(outcome, Unanswerable) for outcome in possible)
    return Robust(held, len(possible), len(outcomes) - len(possible), silent, own[0].of)


def _attempt(stated: Statement, sample: Sample) -> Outcome | Unanswerable:
    assert stated.check is not None
    try:
        return apply(stated.check, sample, stated.unit)
    except Unanswerable as reason:
        return reason


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _sentences(*parts: str) -> str:
    return " ".join(f"{opened(part)}." for part in parts if part)
