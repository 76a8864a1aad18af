"""How everything here is timed and judged: interleaved rounds in one process, ratios round by round, no imports.

A round runs A, B, C one after the other, each so often that it takes 0.1 s, and gives one ratio for each peer; the
median of the rounds' ratios counts. Imports, set-up and compilation come before and are told apart.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

ROUNDS, SHORTEST_S = 5, 0.1
NOT_INSTALLED = "not installed"

Run = Callable[[], Any]
Clock = Callable[[], float]
Bound = Literal["at least", "at most"]


@dataclass(frozen=True)
class Figure:
    """What is asked of a ratio, and of our error."""

    ratio: float
    bound: Bound = "at least"

    def holds(self, ratio: float, slack: float = 1.0) -> bool:
        """Tell whether a ratio meets the figure, or misses it by no more than a factor `slack`."""
        if self.bound == "at least":
            return ratio >= self.ratio / slack
        return ratio <= self.ratio * slack


@dataclass(frozen=True)
class Row:
    """Two timings of the same work, and what the ratio was asked to be.

    ours_s, peer_s : medians over the rounds [s].
    ratio, lowest, highest : of the rounds' ratios, peer over ours ("at least") or ours over peer ("at most").
    ours_error, peer_error : as `error_means` says, of each against the reference.
    error_asked : our error at most; None where nothing is asked.
    """

    name: str
    peer: str
    ours_s: float | None = None
    peer_s: float | None = None
    ratio: float | None = None
    lowest: float | None = None
    highest: float | None = None
    ours_error: float | None = None
    peer_error: float | None = None
    error_means: str = ""
    error_asked: float | None = None
    figure: Figure | None = None
    bound: Bound = "at least"
    rounds: int = 0
    note: str = ""
    before_s: dict[str, float] = field(default_factory=dict)
    """Imports, set-up and first run of each side, outside the times [s]."""

    @property
    def installed(self) -> bool:
        """Tell whether there was a peer to measure."""
        return self.ratio is not None

    @property
    def error_holds(self) -> bool:
        """Tell whether our error is as small as asked; NaN is not."""
        return self.error_asked is None or (self.ours_error is not None and self.ours_error <= self.error_asked)

    @property
    def status(self) -> str:
        """Return what came of the row: only `fails` fails the benchmark."""
        if self.ratio is None:
            return NOT_INSTALLED
        if not self.error_holds:
            return "fails"
        if self.figure is None:
            return "measured"
        if self.figure.holds(self.ratio):
            return "holds"
        return "above half" if self.figure.holds(self.ratio, 2.0) else "fails"


def missing(name: str, peer: str, figure: Figure | None = None) -> Row:
    """Return the row of a peer that is not installed."""
    return Row(name, peer, figure=figure)


def once(run: Run, clock: Clock = time.perf_counter) -> tuple[float, Any]:
    """Run once; return the seconds it took and what it gave."""
    begin = clock()
    result = run()
    return clock() - begin, result


def repeated(run: Run, shortest_s: float = SHORTEST_S, clock: Clock = time.perf_counter) -> float:
    """Return the seconds of one run, from so many in a row that they take `shortest_s`."""
    begin, count = clock(), 0
    while True:
        run()
        count += 1
        passed = clock() - begin
        if passed >= shortest_s:
            return passed / count


def interleaved(
    runs: Mapping[str, Run],
    rounds: int = ROUNDS,
    shortest_s: float = SHORTEST_S,
    clock: Clock = time.perf_counter,
) -> dict[str, list[float]]:
    """Return the seconds of each run in each round, A, B, C, A, B, C."""
    if rounds < 3:
        raise ValueError(f"{rounds} rounds; a median of ratios needs at least 3")
    walls: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            walls[name].append(repeated(run, shortest_s, clock))
    return walls


def compared(
    name: str,
    peer: str,
    ours_s: list[float],
    peer_s: list[float],
    figure: Figure | None = None,
    bound: Bound = "at least",
    **fields: Any,
) -> Row:
    """Return the row of two timings; ratios are of the rounds, never of the medians."""
    bound = figure.bound if figure else bound
    pairs = zip(ours_s, peer_s, strict=True)
    ratios = [own / other if bound == "at most" else other / own for own, other in pairs]
    return Row(
        name,
        peer,
        statistics.median(ours_s),
        statistics.median(peer_s),
        statistics.median(ratios),
        min(ratios),
        max(ratios),
        figure=figure,
        bound=bound,
        rounds=len(ratios),
        **fields,
    )
