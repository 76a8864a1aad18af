"""Rows of a measurement on their way into order: sorted, joined, without repetitions and glitches; each is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError

Array = NDArray[np.float64]


class Ordered:
    """Rows on their way into order; each method does one thing and says it."""

    def __init__(
        self,
        path: Path,
        place: str,
        row: NDArray[np.int64],
        time_s: Array,
        columns: dict[str, Array],
        step: NDArray[np.int64],
    ) -> None:
        self.path, self.place = path, place
        self.row, self.time_s, self.columns, self.step = row, time_s, columns, step
        self.source = np.arange(len(row))
        self.said: list[str] = []

    def optional(self, name: str) -> Array:
        """Return a column; NaN throughout where there is none."""
        return self.columns.get(name, np.full(len(self.time_s), np.nan))

    def keep(self, kept: NDArray[Any]) -> None:
        """Keep some rows, in the order given."""
        self.row, self.time_s, self.step = self.row[kept], self.time_s[kept], self.step[kept]
        self.source = self.source[kept]
        self.columns = {name: values[kept] for name, values in self.columns.items()}

    def sort(self) -> None:
        """Put rows with dates in the order of time."""
        wrong = int((np.diff(self.time_s) < 0.0).sum())
        if wrong:
            self.keep(np.argsort(self.time_s, kind="stable"))
            self.said.append(f"{wrong} rows stand before an earlier one: put in the order of their dates")

    def turn_round(self) -> None:
        """Put a file whose newest row stands first into the order of time."""
        steps = np.diff(self.time_s)
        if len(steps) > 2 and (steps <= 0.0).all() and (steps < 0.0).any():
            self.keep(np.arange(len(self.time_s))[::-1])
            self.said.append("the newest row stands first: turned round")

    def drop_blocks(self) -> None:
        """Leave out blocks of rows that stand there a second time: from where the time goes back to where it goes on.

        Each row of such a block is one from before, time and values, and these are not all the same.
        """
        names = ("voltage_v", "current_a")
        back = np.flatnonzero(np.diff(self.time_s) < 0.0) + 1
        if not len(back):
            return
        seen: dict[tuple[float, ...], int] = {}
        again = np.zeros(len(self.time_s), dtype=bool)
        for at, row in enumerate(
            zip(self.time_s.tolist(), *(self.columns[name].tolist() for name in names), strict=True)
        ):
            again[at] = row in seen
            seen.setdefault(row, at)
        gone = np.zeros(len(again), dtype=bool)
        for begin in back.tolist():
            end = begin + int(np.argmin(again[begin:])) if not again[begin:].all() else len(again)
            last = self.time_s[:begin].max()
            goes_on = end == len(again) or self.time_s[end] > last
            if end - begin > 1 and goes_on and any(np.ptp(self.columns[name][begin:end]) > 0.0 for name in names):
                gone[begin:end] = True
        if gone.any():
            first = int(np.flatnonzero(gone)[0])
            self.said.append(
                f"{int(gone.sum())} rows stand there a second time, from {self.place} {self.row[first]} on: left out"
            )
            self.keep(~gone)

    def sort_few(self) -> None:
        """Put a few rows that changed places into the order of their times, where no time occurs twice."""
        back = np.flatnonzero(np.diff(self.time_s) < 0.0) + 1
        order = np.argsort(self.time_s, kind="stable")
        moved = int((order != np.arange(len(order))).sum())
        if not len(back) or moved > max(4, 0.01 * len(order)) or (np.diff(self.time_s[order]) <= 0.0).any():
            return
        told = ", ".join(str(self.row[at]) for at in back[:5]) + (", ..." if len(back) > 5 else "")
        self.keep(order)
        self.said.append(f"{len(back)} rows stand behind a later one, {self.place} {told}: put in the order of time")

    def continue_resets(self, key: str) -> None:
        """Let a clock that begins anew go on where it was; refuse rows that are out of order."""
        back = np.flatnonzero(np.diff(self.time_s) < 0.0) + 1
        if not len(back):
            return
        steps = np.diff(self.time_s)
        usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 1.0
        for at in back:
            before, after = self.time_s[at - 1], self.time_s[at]
            if after - self.time_s[0] > 0.5 * (before - self.time_s[0]):
                raise UserError(
                    f"{self.path}: {self.place} {self.row[at]}: the time goes back from {before:g} to {after:g} s; "
                    f"where its rows are equally far apart, {key}sample_interval_s={usual:g} counts them instead; or "
                    f"name the column of the time since the start, '{key}columns={{time: \"HEADING\"}}'"
                )
        offset = np.zeros(len(self.time_s))
        for at in back:
            offset[at:] += self.time_s[at - 1] - self.time_s[at] + usual
        self.time_s = self.time_s + offset
        told = ", ".join(str(self.row[at]) for at in back[:5]) + (", ..." if len(back) > 5 else "")
        self.said.append(f"the time begins anew {len(back)} times, in {self.place} {told}: it goes on from before")

    def join_sensors(self, said: list[str]) -> None:
        """Take the rows with a voltage; bring there what other sensors measured at other times."""
        there = ~np.isnan(self.columns["voltage_v"])
        measured = list(self.columns.values())
        for name, values in list(self.columns.items()):
            known = ~np.isnan(values)
            if not known.any():
                if name in ("voltage_v", "current_a"):
                    raise UserError(f"{self.path}: no value of {name} in any row")
                del self.columns[name]
                continue
            missing = there & ~known
            if missing.any():
                order = np.argsort(self.time_s[known], kind="stable")
                at, value = self.time_s[known][order], values[known][order]
                values = values.copy()
                values[missing] = np.interp(self.time_s[missing], at, value)
                self.columns[name] = values
                said.append(f"{name} comes in other rows than the voltage: interpolated in {int(missing.sum())} rows")
        if not there.all():
            empty = np.flatnonzero(np.all([np.isnan(values) for values in measured], axis=0))
            if len(empty):
                first = f"{self.place} {self.row[empty[0]]}"
                said.append(f"{len(empty)} rows without a value left out, the first {first}")
            self.keep(there)

    def drop_repeated(self) -> None:
        """Leave out rows that say again what the row before says."""
        same = np.diff(self.time_s) == 0.0
        for name in ("voltage_v", "current_a"):
            same &= np.diff(self.columns[name]) == 0.0
        repeated = np.append(False, same)
        if repeated.any():
            self.said.append(f"{int(repeated.sum())} rows repeat the row before: left out")
            self.keep(~repeated)

    def drop_glitches(self) -> None:
        """Leave out single voltages that no battery has: near zero, or far from both sides without a current to it."""
        volts, amperes = self.columns["voltage_v"], self.columns["current_a"]
        if len(volts) < 5:
            return
        usual = float(np.median(volts))
        low = (volts < 0.2 * usual) | (volts > 2.5 * usual)
        before, after = np.roll(volts, 1), np.roll(volts, -1)
        middle = 0.5 * (before + after)
        calm = np.abs(np.roll(amperes, 1) - np.roll(amperes, -1)) < 0.05 * (np.ptp(amperes) + 1e-12)
        calm &= np.abs(amperes - np.roll(amperes, 1)) < 0.05 * (np.ptp(amperes) + 1e-12)
        spike = calm & (np.abs(volts - middle) > np.maximum(0.03 * usual, 5.0 * np.abs(before - after)))
        spike[[0, -1]] = False
        wrong = low | spike
        if 0 < wrong.sum() <= 0.01 * len(volts) + 1:
            rows = np.flatnonzero(wrong)
            told = ", ".join(f"{self.place} {self.row[at]} ({volts[at]:g} V)" for at in rows[:8])
            more = f" and {len(rows) - 8} more" if len(rows) > 8 else ""
            self.said.append(f"no voltage of a battery, left out: {told}{more}")
            self.keep(~wrong)
        elif wrong.any():
            at = int(np.flatnonzero(wrong)[0])
            raise UserError(
                f"{self.path}: {int(wrong.sum())} of {len(volts)} voltages are near zero, far above the others or jump "
                "without a current, "
                f"the first in {self.place} {self.row[at]}, {volts[at]:g} V; is it the battery's voltage? "
                "'measured.columns={voltage_v: \"HEADING\"}'"
            )

    def drop_wild_currents(self) -> None:
        """Leave out single currents far from those on both sides to which the voltage does not answer."""
        volts, amperes = self.columns["voltage_v"], self.columns["current_a"]
        if len(amperes) < 20:
            return
        span = float(np.ptp(np.percentile(amperes, [0.2, 99.8])))
        before, after = np.roll(amperes, 1), np.roll(amperes, -1)
        far = np.abs(amperes - 0.5 * (before + after)) > 0.5 * span + 1e-9
        far &= np.abs(before - after) < 0.05 * span + 1e-9
        far[[0, -1]] = False
        # By how much the voltage answers to other changes of the current: at once, or a row later.
        change = np.abs(np.diff(amperes))
        usual = (change > 0.2 * span) & ~far[1:] & ~far[:-1]
        if not far.any() or usual.sum() < 3 or span == 0.0:
            return
        later = np.append(volts[2:], volts[-1])
        ohm = float(np.median((np.abs(later - volts[:-1]) / np.maximum(change, 1e-12))[usual]))
        answer = np.maximum(np.abs(volts - np.roll(volts, 1)), np.abs(np.roll(volts, -1) - np.roll(volts, 1)))
        wild = far & (answer < 0.2 * ohm * np.abs(amperes - before))
        if wild.any():
            rows = np.flatnonzero(wild)
            told = ", ".join(f"{self.place} {self.row[at]} ({amperes[at]:g} A)" for at in rows[:8])
            more = f" and {len(rows) - 8} more" if len(rows) > 8 else ""
            self.said.append(f"no voltage answers to the current, left out: {told}{more}")
            self.keep(~wild)
