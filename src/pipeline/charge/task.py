"""One charge: what it is made from, and what came of it, put into columns as they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import compile_cell
from pipeline.cell.records import Battery
from pipeline.charge.energy import balance
from pipeline.charge.outcome import Columns, Outcome, phases, trace, waveform
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.summary import Quantity, summarise

# Column of a sample.
_ENERGY_IN_WH = 6


class Supply(NamedTuple):
    """Power available at the battery's terminals, constant from each time to the next; inf is a bench supply.

    time_s : (m,), rising from 0; power_w : (m,).
    drawn_per_w, side_w : what the source gives for a watt at the terminals [1], and for side loads [W], (m,) each;
        where not given, nothing is lost on the way and nothing hangs there.
    """

    time_s: NDArray[np.float64]
    power_w: NDArray[np.float64]
    drawn_per_w: NDArray[np.float64] | None = None
    side_w: NDArray[np.float64] | None = None

    def drawn_of(self, samples: NDArray[np.float64]) -> float:
        """Return the energy drawn at the source over a charge [J], from its samples."""
        return self.drawn_j(samples[:, 0], samples[:, _ENERGY_IN_WH] * 3600.0)

    def drawn_j(self, time_s: NDArray[np.float64], put_in_j: NDArray[np.float64]) -> float:
        """Return the energy drawn at the source over a charge [J].

        Arguments
        ---------
        time_s, put_in_j : ends of intervals from 0 on, and the energy put in up to each, shape (n,).
        """
        if self.drawn_per_w is None and self.side_w is None:
            return float(put_in_j[-1]) if len(put_in_j) else 0.0
        put_in = put_in_j.copy()
        put_in[1:] -= put_in_j[:-1]
        if self.drawn_per_w is not None:
            begins = np.append(0.0, time_s[:-1])
            rows = np.searchsorted(self.time_s, 0.5 * (time_s + begins), side="right") - 1
            put_in *= self.drawn_per_w[rows]
        side_j = 0.0
        if self.side_w is not None:
            end_s = time_s[-1] if len(time_s) else 0.0
            edges = np.append(self.time_s[1:], np.inf)
            side_j = float(np.sum(self.side_w * np.maximum(0.0, np.minimum(edges, end_s) - self.time_s)))
        return float(np.sum(put_in)) + side_j


BENCH = Supply(np.zeros(1), np.full(1, np.inf))


class Task(NamedTuple):
    """One charge: the arguments of `simulate`."""

    battery: Battery
    mode: Mode
    supply: Supply
    settings: ChargeSettings
    engine: EngineSettings


class Charge:
    """What came of a charge: columns of the four tables, and the summary, each made when it is first asked for.

    Arguments
    ---------
    task : what it was made from.
    finish : what gives the finished run; called once, and only if something is asked for.
    summarised : what gives the summary, where that is made for many charges at once.
    """

    def __init__(
        self, task: Task, finish: Callable[[], Outcome], summarised: Callable[[], list[Quantity]] | None = None
    ) -> None:
        self._task, self._finish, self._summarised = task, finish, summarised

    @cached_property
    def _outcome(self) -> Outcome:
        return self._finish()

    @cached_property
    def trace(self) -> Columns:
        """Return the samples as the columns of CHARGE_TRACE."""
        return trace(self._outcome, self._task.settings.ambient_c)

    @cached_property
    def waveform(self) -> Columns:
        """Return what was kept at full resolution as the columns of CHARGE_WAVEFORM."""
        return waveform(self._outcome)

    @cached_property
    def phases(self) -> Columns:
        """Return the phases that were run as the columns of CHARGE_PHASES."""
        return phases(self._outcome)

    @cached_property
    def energy(self) -> Columns:
        """Return the balance of energy by path."""
        done, battery = self._outcome, self._task.battery
        cell = compile_cell(battery) if done.cell is None else done.cell
        return balance(cell, done.book.gains, done.start, done.run["state"], tuple(battery.pairs))

    @cached_property
    def summary(self) -> list[Quantity]:
        """Return the quantities of the charge."""
        if self._summarised is not None:
            return self._summarised()
        done, samples = self._outcome, self._outcome.book.samples[: self._outcome.book.filled[0]]
        return summarise(done, self._task.settings, self._task.supply.drawn_of(samples))
