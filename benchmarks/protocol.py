"""How everything here is timed and judged: interleaved rounds in one process, ratios round by round, no imports.

A round runs A, B, C one after the other, each so often that it takes 0.1 s, and gives one ratio for each peer; the
median of the rounds' ratios counts. Imports, set-up and compilation come before and are told apart. The ratio of the
processor's time, which other work on the machine disturbs less, stands beside that of the clock and decides nothing.
"""

from __future__ import annotations

import resource
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
class Times:
    """Seconds of one run in each round, by the clock and of the processor, those of its own processes included."""

    wall_s: list[float]
    processor_s: list[float]

    def scaled(self, factor: float) -> Times:
        """Return the times of so many times the work."""
        return Times([factor * wall for wall in self.wall_s], [factor * spent for spent in self.processor_s])


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
    processor_ratio : median of the rounds' ratios of the processor's time.
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
    processor_ratio: float | None = None
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


def processor_time() -> float:
    """Return the processor's time of this process and of those it has waited for [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def repeated(run: Run, shortest_s: float = SHORTEST_S, clock: Clock = time.perf_counter) -> tuple[float, float]:
    """Return the seconds of one run, and of the processor, from so many in a row that they take `shortest_s`."""
    spent, begin, count = processor_time(), clock(), 0
    while True:
        run()
        count += 1
        passed = clock() - begin
        if passed >= shortest_s:
            return passed / count, (processor_time() - spent) / count


def interleaved(
    runs: Mapping[str, Run],
    rounds: int = ROUNDS,
    shortest_s: float = SHORTEST_S,
    clock: Clock = time.perf_counter,
) -> dict[str, Times]:
    """Return the seconds of each run in each round, A, B, C, A, B, C."""
    if rounds < 3:
        raise ValueError(f"{rounds} rounds; a median of ratios needs at least 3")
    times = {name: Times([], []) for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            wall_s, processor_s = repeated(run, shortest_s, clock)
            times[name].wall_s.append(wall_s)
            times[name].processor_s.append(processor_s)
    return times


def compared(
    name: str,
    peer: str,
    ours: Times,
    theirs: Times,
    figure: Figure | None = None,
    bound: Bound = "at least",
    **fields: Any,
) -> Row:
    """Return the row of two timings; ratios are of the rounds, never of the medians."""
    bound = figure.bound if figure else bound
    ratios = _ratios(ours.wall_s, theirs.wall_s, bound)
    return Row(
        name,
        peer,
        statistics.median(ours.wall_s),
        statistics.median(theirs.wall_s),
        statistics.median(ratios),
        min(ratios),
        max(ratios),
        statistics.median(_ratios(ours.processor_s, theirs.processor_s, bound)),
        figure=figure,
        bound=bound,
        rounds=len(ratios),
        **fields,
    )


def _ratios(ours: list[float], theirs: list[float], bound: Bound) -> list[float]:
    pairs = zip(ours, theirs, strict=True)
    return [own / other if bound == "at most" else other / own for own, other in pairs]
