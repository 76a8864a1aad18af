"""The summaries of a block of a population: numbers for all its charges at once, words once for all that end alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.charge.lot import MARKS, PHASES, SAMPLES, Lot
from pipeline.charge.outcome import Outcome, goals, missed, missed_goal, reaches, reason
from pipeline.charge.protocol import Protocol
from pipeline.charge.state import DEPTH
from pipeline.charge.summary import Ends, Quantity, numbers, quantities
from pipeline.charge.task import Task


class Ended:
    """Charges of a lot that have ended.

    Arguments
    ---------
    lot, tasks, protocols : what was run, a row each.
    """

    def __init__(self, lot: Lot, tasks: Sequence[Task], protocols: Sequence[Protocol]) -> None:
        self.lot, self._tasks, self._protocols = lot, tasks, protocols
        self._goals: dict[int, dict[str, float]] = {}
        self._words: dict[tuple[object, ...], tuple[str, str]] = {}

    def summary(self, row: int, outcome: Callable[[], Outcome]) -> list[Quantity]:
        """Return the quantities of a charge; `outcome` gives its finished run, where its words are its own."""
        begin, end = self.lot.begin[row, MARKS], self.lot.end[row, MARKS]
        ended, not_reached = self._told(row, outcome)
        settings = self._tasks[row].settings
        return quantities(settings, self.lot.marks[begin:end], self._numbers[row], ended, not_reached)

    @cached_property
    def _numbers(self) -> list[list[float]]:
        lot = self.lot
        ambient_c = np.array([task.settings.ambient_c for task in self._tasks])
        ends = Ends(
            lot.totals, lot.start, lot.state, lot.peak_k[:, 0], lot.end_s,
            np.array([self._drawn_j(row) for row in range(len(self._tasks))]), ambient_c + ZERO_CELSIUS_K,
            lot.settled, lot.counts.astype(np.float64),
        )  # fmt: skip
        # Of those that failed there may be anything.
        with np.errstate(all="ignore"):
            rows: list[list[float]] = numbers(ends).tolist()
        return rows

    def _drawn_j(self, row: int) -> float:
        begin = int(self.lot.begin[row, SAMPLES])
        samples = self.lot.samples[begin : begin + int(self.lot.filled[row, 0])]
        return self._tasks[row].supply.drawn_of(samples)

    def _told(self, row: int, outcome: Callable[[], Outcome]) -> tuple[str, str]:
        """Return what ended a charge, and what it did not reach; the same for all that ran alike and missed no goal."""
        protocol, begin = self._protocols[row], int(self.lot.begin[row, PHASES])
        ran = self.lot.phases[begin : begin + int(self.lot.filled[row, 1])].tolist()
        wanted = self._goals.get(id(protocol))
        if wanted is None:
            wanted = self._goals[id(protocol)] = goals(protocol)
        key = (
            id(protocol),
            reaches(wanted, 1.0 - float(self.lot.state[row, DEPTH])),
            *((phase[3], phase[7], phase[1] == phase[2]) for phase in ran),
        )
        found = self._words.get(key)
        if found is None:
            done = outcome()
            found = reason(done, -1), missed(done)
            if not missed_goal(done):
                self._words[key] = found
        return found
