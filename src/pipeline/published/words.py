"""The words of verdicts: which there are, what each means, and how one follows from basis, truth and robust share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

Basis = Literal["paper_data", "mathematics", "model", "search", "none"]
Word = Literal["holds", "contradicted", "not reproduced", "undecided", "calibrated", "not checkable"]

ENOUGH = (4, 5)
"""Share of the ranges over which a claim must be true to hold, and false not to be reproduced: four fifths."""
WORDS: dict[str, tuple[str, str]] = {
    "holds": ("✓", "true; of a model or a search, over at least 80 % of the estimates' ranges or of the seeds"),
    "not reproduced": ("✗", "false over at least 80 % of them: our model says otherwise, which refutes nothing"),
    "undecided": ("≈", "true over some and false over others; the share stands beside it"),
    "contradicted": ("⊘", "the paper's own numbers, or mathematics, say otherwise"),
    "calibrated": ("◐", "true, but a parameter was fitted to the statement: no evidence"),
    "not checkable": ("○", "the paper gives too little, or asks for more than this run did"),
}
"""Word -> its symbol and what it means, in the order in which they are counted."""
BASES: dict[str, str] = {
    "paper_data": "arithmetic of the paper alone",
    "mathematics": "mathematics",
    "model": "our model",
    "search": "our searches and trainings",
    "none": "not enough information",
}
"""What an answer rests on -> in words."""


PARAMETERS, SEEDS = "points of the estimated parameters", "experiments with other seeds"
RESAMPLED = "resamples of the independent runs"
"""What the points of an ensemble are."""


class Robust(NamedTuple):
    """In how many points of the estimated parameters, or experiments of other seeds, a claim is true.

    Arguments
    ---------
    held, counted : points in which it is true, and all of them that count.
    left_out : points that no battery can have, which do not count.
    unanswered : points without an answer, which count as false.
    of : what the points are, for people.
    """

    held: int
    counted: int
    left_out: int = 0
    unanswered: int = 0
    of: str = PARAMETERS

    @property
    def share(self) -> float:
        """Return the share in which it is true [1]."""
        return self.held / self.counted

    def interval(self) -> tuple[float, float]:
        """Return the 95 % interval of the share as for independent draws (Clopper and Pearson 1934)."""
        from scipy.stats import binomtest  # half a second, and most verdicts are read, not made

        found = binomtest(self.held, self.counted).proportion_ci(0.95, method="exact")
        return float(found.low), float(found.high)

    def sentence(self) -> str:
        """Return it in words."""
        low, high = self.interval()
        silent = f", {self.unanswered} of the others without an answer" if self.unanswered else ""
        apart = f"; {self.left_out} left out as impossible" if self.left_out else ""
        return f"true in {self.held} of {self.counted} {self.of} ({100 * low:.0f} to {100 * high:.0f} %){silent}{apart}"


def word(basis: Basis, holds: bool, robust: Robust | None = None, calibrated: bool = False) -> Word:
    """Return the verdict on a statement that can be checked.

    Arguments
    ---------
    basis : what the answer rests on.
    holds : whether the predicate is true for the study's own values.
    robust : in how many points it is true; none where nothing behind it is estimated or drawn.
    calibrated : whether a parameter behind it was fitted to the statement.
    """
    if calibrated and holds:
        return "calibrated"
    if basis in ("paper_data", "mathematics"):
        return "holds" if holds else "contradicted"
    found = Robust(int(holds), 1) if robust is None else robust
    share, of = ENOUGH
    if of * found.held >= share * found.counted:
        return "holds"
    return "not reproduced" if of * (found.counted - found.held) >= share * found.counted else "undecided"


def counted(verdicts: Mapping[str, Sequence[Any]]) -> dict[str, list[tuple[str, int]]]:
    """Return the words of a table of verdicts with their numbers, arithmetic of the paper apart from the rest.

    Arguments
    ---------
    verdicts : columns of the table.

    Returns
    -------
    `statements` and `arithmetic` -> word and number, words that do not occur left out.
    """
    rows = list(zip(map(str, verdicts["basis"]), map(str, verdicts["verdict"]), strict=True))
    return {
        "statements": _ordered(found for basis, found in rows if basis != "paper_data"),
        "arithmetic": _ordered(found for basis, found in rows if basis == "paper_data"),
    }


def _ordered(found: Iterable[str]) -> list[tuple[str, int]]:
    numbers = Counter(found)
    return [(name, numbers[name]) for name in WORDS if numbers[name]]
