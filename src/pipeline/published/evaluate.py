"""From statements and artefacts to verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any, Literal

from pipeline.kernel.tables import Column, Table
from pipeline.published.artefacts import Key, Lookup, Sample, Unanswerable, key
from pipeline.published.predicates import Outcome, apply
from pipeline.published.records import Statement, read_tables, read_values
from pipeline.published.reference import kind

Verdict = Literal["holds", "fails", "not checkable", "calibrated", "contradicted"]
VERDICTS = Table(
    "verdicts",
    "Every published statement that was examined, with its computed verdict",
    (
        Column("statement", "", "identifier of the statement", "text"),
        Column("where", "", "where it stands in the paper", "text"),
        Column("says", "", "what it says", "text"),
        Column("reading", "", "how the words became a predicate, and why this tolerance", "text"),
        Column("basis", "", "paper_data, model or none", "text"),
        Column("verdict", "", "holds, fails, not checkable, calibrated or contradicted", "text"),
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
            "share of the range of the estimated parameters over which a claim holds",
            optional=True,
        ),
        Column("explanation", "", "the numbers behind the verdict in a sentence", "text"),
    ),
)
COLUMNS = [column.name for column in VERDICTS.columns]


def evaluate(
    statements: Mapping[str, Statement],
    artefacts: Lookup,
    calibrated_to: Collection[str] = (),
    ensemble: Iterable[Mapping[Key, float]] = (),
) -> dict[str, list[Any]]:
    """Return the columns of the table of verdicts, a row per statement in the order given.

    Arguments
    ---------
    statements : identifier -> statement.
    artefacts : what this run made.
    calibrated_to : identifiers of the statements that a parameter they depend on was calibrated to.
    ensemble : for each sample of the estimated parameters, the named numbers that it changes.
    """
    samples = [Sample(artefacts, found) for found in ensemble]
    rows = [_row(name, stated, artefacts, samples, name in calibrated_to) for name, stated in statements.items()]
    return {column: [row[column] for row in rows] for column in COLUMNS}


def verdict_of(holds: bool, calibrated: bool) -> Verdict:
    """Return the verdict on a checkable statement.

    An independent answer either holds or contradicts the paper. An answer calibrated to the statement can do neither:
    it is `calibrated` where the predicate holds, and `fails` where not even the calibration brought it about.
    """
    if calibrated:
        return "calibrated" if holds else "fails"
    return "holds" if holds else "contradicted"


def _row(name: str, stated: Statement, artefacts: Lookup, samples: list[Sample], calibrated: bool) -> dict[str, Any]:
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"statement": name, **stated.model_dump(include={"where", "says", "reading", "basis", "unit"})}
    if stated.check is None:
        return row | {"verdict": "not checkable", "explanation": f"Missing: {stated.missing}"}
    try:
        outcome = apply(stated.check, artefacts, stated.unit)
    except Unanswerable as reason:
        return row | {"verdict": "not checkable", "explanation": f"Missing: {reason}."}
    share, counted = _robust_share(stated, samples)
    return row | {
        "verdict": verdict_of(outcome.holds, calibrated),
        "published_value": _finite(outcome.published) if stated.form == "number" else None,
        "computed_value": _finite(outcome.computed),
        "tolerance": _finite(outcome.tolerance),
        "margin": _finite(outcome.margin),
        "robust_share": share,
        "explanation": _sentences(outcome.sentence, counted),
    }


def _robust_share(stated: Statement, samples: list[Sample]) -> tuple[float | None, str]:
    if not samples or not _varies(stated, samples):
        return None, ""
    outcomes = [_attempt(stated, sample) for sample in samples]
    held = sum(outcome is not None and outcome.holds for outcome in outcomes)
    empty = outcomes.count(None)
    silent = f" ({empty} without an answer, counted as failing)" if empty else ""
    return held / len(samples), f"holds in {held} of {len(samples)} samples of the estimated parameters{silent}"


def _varies(stated: Statement, samples: list[Sample]) -> bool:
    """Tell whether the ensemble holds everything that would change with the estimated parameters."""
    if stated.basis != "model" or read_tables(stated):
        return False
    known = {found for sample in samples for found in sample.numbers}
    kinds = {kind(artefact) for artefact, _, _ in known}
    varying = [value for value in read_values(stated) if kind(value.artefact) in kinds]
    return bool(varying) and all(key(value) in known for value in varying)


def _attempt(stated: Statement, sample: Sample) -> Outcome | None:
    assert stated.check is not None
    try:
        return apply(stated.check, sample, stated.unit)
    except Unanswerable:
        return None


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _sentences(*parts: str) -> str:
    return " ".join(f"{part[0].upper()}{part[1:]}." for part in parts if part)
