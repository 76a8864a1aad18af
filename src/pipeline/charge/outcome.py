"""A finished charge: its tables, what ended it, and what it was to reach and did not."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K, Cell
from pipeline.charge.protocol import UNTIL, Course, Protocol
from pipeline.charge.record_keeping import SUPPLY_LIMITED_S, Book
from pipeline.charge.segment import LIMITS
from pipeline.charge.settling import Settled
from pipeline.charge.state import DEPTH, TOTAL, Run

Columns = dict[str, Any]

_WORDS = {
    "elapsed_s": ("elapsed", " s"),
    "soc": ("soc", ""),
    "voltage_v": ("voltage", " V"),
    "current_a": ("current", " A"),
    "temperature_c": ("temperature", " degC"),
    "voltage_drop_v": ("voltage below its peak by", " V"),
    "temperature_rate_k_s": ("temperature rate", " K/s"),
}
# What ends a charge that is done; time and temperature end one that is given up.
_GOALS = ("soc", "voltage_v", "current_a", "voltage_drop_v", "temperature_rate_k_s")
_ROUNDING = 1e-9
_MOST_NAMED = 4


@dataclass(frozen=True)
class Outcome:
    """A finished run as the kernels left it, with what it was run on; of a population's, the cell is not kept."""

    cell: Cell
    protocol: Protocol
    run: Run
    book: Book
    start: NDArray[np.float64]
    end_s: float
    settled: Settled | None = None

    @cached_property
    def ran(self) -> list[list[float]]:
        """Return the rows of the phases that were run."""
        rows: list[list[float]] = self.book.phases[: self.book.filled[1]].tolist()
        return rows


def trace(outcome: Outcome, ambient_c: float) -> Columns:
    """Return the samples as the columns of CHARGE_TRACE."""
    rows = outcome.book.samples[: outcome.book.filled[0]].T
    names = (
        "Test Time / s",
        "Voltage / V",
        "Current / A",
        "Step Count / 1",
        "Charging Capacity / Ah",
        "Discharging Capacity / Ah",
        "Charging Energy / Wh",
        "Discharging Energy / Wh",
        "Surface Temperature / degC",
        "soc",
        "voltage_min_v",
        "voltage_max_v",
        "current_min_a",
        "current_max_a",
        "side_current_a",
        "supply_limited_share",
        "voltage_limited_share",
    )
    columns: Columns = {name: row.copy() for name, row in zip(names, rows, strict=True)}
    columns["Step Count / 1"] = columns["Step Count / 1"].astype(np.int64)
    columns["Surface Temperature / degC"] -= ZERO_CELSIUS_K
    columns["Ambient Temperature / degC"] = np.full(rows.shape[1], ambient_c)
    return columns


def waveform(outcome: Outcome) -> Columns:
    """Return what was kept at full resolution as the columns of CHARGE_WAVEFORM."""
    rows = outcome.book.waveform[: outcome.book.filled[2]]
    rows = rows[np.argsort(rows[:, 0], kind="stable")].T
    return {
        "window": rows[0].astype(np.int64),
        "time_s": rows[1].copy(),
        "current_a": rows[2].copy(),
        "voltage_v": rows[3].copy(),
        "soc": rows[4].copy(),
        "temperature_c": rows[5] - ZERO_CELSIUS_K,
    }


def phases(outcome: Outcome) -> Columns:
    """Return the phases that were run as the columns of CHARGE_PHASES."""
    rows = outcome.book.phases[: outcome.book.filled[1]]
    return {
        "phase": [outcome.protocol.courses[int(course)].name for course in rows[:, 7]],
        "start_s": rows[:, 1].copy(),
        "end_s": rows[:, 2].copy(),
        "end_reason": [_reason_of_phase(outcome, row) for row in range(len(rows))],
        "start_soc": 1.0 - rows[:, 4],
        "end_soc": 1.0 - rows[:, 5],
        "end_temperature_c": rows[:, 6] - ZERO_CELSIUS_K,
    }


def reason(outcome: Outcome, row: int) -> str:
    """Return what ended a phase.

    Arguments
    ---------
    row : number of the phase among those that were run; -1 is what ended the charge.
    """
    name, limits, of_stop = _end(outcome, row)
    return f"{'stop: ' if of_stop else ''}{_told(name, limits)}"


def missed(outcome: Outcome) -> str:
    """Return in words what a charge was to do and did not; empty where there is nothing to say.

    Which of its goals it did not reach and why, which phases never ran, and which were over as they began. Goals are
    the stops of SOC, voltage and current and those that are watched for, of the charge and of its last phase; any of
    them may end the charge. Time and temperature are limits: a charge that has no goal beside them misses none.
    """
    goal = missed_goal(outcome)
    begun = {outcome.protocol.courses[int(row[7])].name for row in outcome.ran}
    parts = [goal, _not_held(outcome) if goal else "", never_ran(outcome.protocol, begun), *_skipped(outcome)]
    return "; ".join(part for part in parts if part)


def goals(protocol: Protocol) -> dict[str, float]:
    """Return the limits that end a charge which is done: those of the sheet itself and of its last phase."""
    last = protocol.courses[-1]
    of_last = {"soc": last.edge_soc} if last.edge_soc is not None else {}
    wanted = {**of_last, **last.until, **_own_stops(protocol)}
    return {goal: wanted[goal] for goal in _GOALS if goal in wanted}


def either(limits: Mapping[str, float]) -> str:
    """Return limits in words, any of which may end a charge."""
    return " or ".join(_limit(goal, value) for goal, value in limits.items())


def reaches(wanted: Mapping[str, float], end_soc: float) -> bool:
    """Tell whether a charge came to the SOC among its goals."""
    return end_soc >= wanted.get("soc", 2.0) - _ROUNDING


def _own_stops(protocol: Protocol) -> dict[str, float]:
    return {goal: value for goal, value in protocol.stop.items() if goal not in protocol.built_in}


def missed_goal(outcome: Outcome) -> str:
    """Return in words which goal a charge did not reach, and why; empty where it has none or reached one."""
    protocol, totals = outcome.protocol, outcome.book.totals
    name, limits, of_stop = _end(outcome, -1)
    last, stops = protocol.courses[-1], _own_stops(protocol)
    full = of_stop and name in protocol.built_in
    wanted = goals(protocol)
    if full and not wanted:
        wanted = {"elapsed_s": protocol.stop["elapsed_s"]}
    ended = protocol.courses[int(outcome.ran[-1][7])]
    done = name in stops if of_stop else ended.group == last.group and name not in stops
    end_soc = 1.0 - float(outcome.run["state"][DEPTH])
    if not wanted or (name in _GOALS and done) or reaches(wanted, end_soc):
        return ""
    # The last step tells the current only where every step is integrated: pulses may be crossed in closed form.
    flowing = f", {outcome.run['at'][TOTAL, 2]:.4g} A flowing" if "current_a" in wanted and _steady(ended) else ""
    lit_s = float(totals[SUPPLY_LIMITED_S])
    dim = f", the supply at its limit for {_hours(lit_s)}" if lit_s > 0.0 and name == "elapsed_s" else ""
    after = "" if of_stop and name == "elapsed_s" else f" after {_hours(outcome.end_s)}"
    why = "the battery was full" if full else f"{_ended_by(of_stop, name)} {_limit(name, limits[name])}"
    return f"{either(wanted)} not reached, {why}{after} at SOC {end_soc:.4g}{flowing}{dim}"


def _ended_by(of_stop: bool, name: str) -> str:
    """Return the words before the limit that ended a charge."""
    its = "its " if name in ("elapsed_s", "temperature_c") else ""
    return f"stopped by {its and 'the '}".rstrip() if of_stop else f"the last phase ended by {its}".rstrip()


def _steady(course: Course) -> bool:
    return math.isinf(course.segments[0].length_s)


def _not_held(outcome: Outcome) -> str:
    """Return which voltage the phase in which the charge ended was to hold and never came to."""
    rows = outcome.ran
    course = outcome.protocol.courses[int(rows[-1][7])]
    before_s = rows[-2][8] if len(rows) > 1 else 0.0
    if not course.waveform.holds_voltage or rows[-1][8] > before_s:
        return ""
    return f"{course.name} never held its {course.values['voltage_v']:g} V"


def never_ran(protocol: Protocol, begun: Collection[str]) -> str:
    """Return in words which phases and stages, in the order of the sheet, are not among those that were begun."""
    names = dict.fromkeys(course.name for course in protocol.courses)
    return _listed([name for name in names if name not in begun], "never ran")


def _skipped(outcome: Outcome) -> list[str]:
    """Return what is to be said of the phases and stages whose end was met in every turn as they began."""
    names = [outcome.protocol.courses[int(row[7])].name for row in outcome.ran]
    ran = {name for row, name in enumerate(names) if not _met_at_start(outcome, row)}
    said = {name: _reason_of_phase(outcome, row) for row, name in enumerate(names) if name not in ran}
    return [f"{name} skipped: {why}" for name, why in said.items()]


def _met_at_start(outcome: Outcome, row: int) -> bool:
    """Tell whether a phase was over as it began; not where the whole charge was."""
    return outcome.ran[row][1] == outcome.ran[row][2] and not _end(outcome, row)[2]


def _reason_of_phase(outcome: Outcome, row: int) -> str:
    return reason(outcome, row) + (", met as it began" if _met_at_start(outcome, row) else "")


def _listed(names: Sequence[str], told: str) -> str:
    if len(names) > _MOST_NAMED:
        return f"{names[0]}, {names[1]}, ... {names[-1]} ({len(names)} phases) {told}"
    return f"{' and '.join(filter(None, [', '.join(names[:-1]), names[-1]]))} {told}" if names else ""


def _end(outcome: Outcome, row: int) -> tuple[str, Mapping[str, float], bool]:
    """Return which limit ended a phase, the limits that it is one of, and whether they are those of the charge."""
    code, course = int(outcome.ran[row][3]), outcome.protocol.courses[int(outcome.ran[row][7])]
    if code == 2 * LIMITS:
        assert course.edge_soc is not None
        return "soc", {"soc": course.edge_soc}, False
    return UNTIL[code % LIMITS], outcome.protocol.stop if code >= LIMITS else course.until, code >= LIMITS


def _told(name: str, limits: Mapping[str, float]) -> str:
    word, unit = _WORDS[name]
    return f"{word} {limits[name]:g}{unit}"


def _goal(name: str, value: float) -> str:
    return f"SOC {value:g}" if name == "soc" else _told(name, {name: value})


def _limit(name: str, value: float) -> str:
    if name == "elapsed_s":
        return f"{_hours(value)} time limit"
    if name == "temperature_c":
        return f"{value:g} °C temperature limit"
    return _goal(name, value)


def _hours(seconds: float) -> str:
    return f"{seconds / 3600.0:.4g} h" if seconds >= 3600.0 else f"{seconds:.4g} s"
