"""A finished charge: its tables, what ended it, and what it was to reach and did not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K, Cell
from pipeline.charge.protocol import UNTIL, Protocol
from pipeline.charge.record_keeping import Book
from pipeline.charge.records import Mode
from pipeline.charge.segment import LIMITS
from pipeline.charge.state import DEPTH, Run

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


@dataclass(frozen=True)
class Outcome:
    """A finished run as the kernels left it, with what it was run on."""

    cell: Cell
    protocol: Protocol
    run: Run
    book: Book
    start: NDArray[np.float64]
    end_s: float


def trace(outcome: Outcome, ambient_c: float) -> Columns:
    """Return the samples as the columns of CHARGE_TRACE."""
    rows = outcome.book.samples[: outcome.book.filled[0]].T
    names = (
        "Test Time / s",
        "Voltage / V",
        "Current / A",
        "Step Index / 1",
        "Charging Capacity / Ah",
        "Discharging Capacity / Ah",
        "Charging Energy / Wh",
        "Discharging Energy / Wh",
        "Surface Temperature T1 / degC",
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
    columns["Step Index / 1"] = columns["Step Index / 1"].astype(np.int64)
    columns["Surface Temperature T1 / degC"] -= ZERO_CELSIUS_K
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
        "end_reason": [reason(outcome, row) for row in range(len(rows))],
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


def missed(outcome: Outcome, mode: Mode) -> str | None:
    """Return in words which of its goals a charge did not reach, and why; None where it reached one or had none.

    Goals are the stops of SOC, voltage and current and those that are watched for; any of them may end the charge.
    Time and temperature are limits: a charge that has no goal beside them misses nothing.
    """
    name, limits, of_stop = _end(outcome, -1)
    goals = {goal: outcome.protocol.stop[goal] for goal in _GOALS if goal in mode.stop.given}
    end_soc = 1.0 - float(outcome.run["state"][DEPTH])
    if not goals or (name in _GOALS and (of_stop or name not in goals)):
        return None
    if end_soc >= goals.get("soc", 2.0) - _ROUNDING:
        return None
    said = " or ".join(_goal(goal, value) for goal, value in goals.items())
    where = "" if of_stop else "the last phase ended, "
    return f"{said} not reached, SOC {end_soc:.4g} at {_hours(outcome.end_s)}: {where}{_limit(name, limits[name])}"


def _end(outcome: Outcome, row: int) -> tuple[str, Mapping[str, float], bool]:
    """Return which limit ended a phase, the limits that it is one of, and whether they are those of the charge."""
    rows = outcome.book.phases[: outcome.book.filled[1]]
    code, course = int(rows[row, 3]), outcome.protocol.courses[int(rows[row, 7])]
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
        return f"{value:g} degC temperature limit"
    return _goal(name, value)


def _hours(seconds: float) -> str:
    return f"{seconds / 3600.0:.4g} h" if seconds >= 3600.0 else f"{seconds:.4g} s"
