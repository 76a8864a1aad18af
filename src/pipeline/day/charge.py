"""A charge over a day: legs from one switching to the next, the engine's state carried on between them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.flows import ENDED, MODE_1, MODE_2, OFF, Change, charging_spans, closed
from pipeline.bus.load import held
from pipeline.bus.records import Switching
from pipeline.cell.circuit import ZERO_CELSIUS_K, compile_cell
from pipeline.cell.records import Battery
from pipeline.charge import drive
from pipeline.charge.checks import check
from pipeline.charge.controller import Control, compile_control, interrupt
from pipeline.charge.energy import balance
from pipeline.charge.outcome import Outcome, either, goals, missed_goal, never_ran, reason, trace
from pipeline.charge.period import TICK, new_clock
from pipeline.charge.program import compile_program
from pipeline.charge.protocol import Course, Protocol, resolve
from pipeline.charge.record_keeping import (
    CHARGE_IN,
    CHARGE_OUT,
    CURRENT_LIMITED_S,
    SUPPLY_LIMITED_S,
    VOLTAGE_LIMITED_S,
)
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.segment import EDGE, ELAPSED, LIMITS
from pipeline.charge.simulate import Supply, launch, new_book, resting_run
from pipeline.charge.state import DEPTH, TEMPERATURE, Run
from pipeline.charge.watching import NO_PEAK
from pipeline.charge.waveforms import Rest, Sampled
from pipeline.day.records import DayConditions
from pipeline.errors import EngineError

Array = NDArray[np.float64]


class Surroundings(NamedTuple):
    """What a day brings to the battery.

    Arguments
    ---------
    time_s, power_w : power at the battery's terminals, constant from each time to the next, shape (n,).
    ambient_c : temperature of the air in the same rows, shape (n,).
    end_s : end of the day [s].
    kept_j : energy at the battery's terminals that the bus can keep while a pulse pauses, shape (n,); none where not.
    """

    time_s: Array
    power_w: Array
    ambient_c: Array
    end_s: float
    kept_j: Array | None = None


@dataclass(frozen=True)
class DayCharge:
    """What came of a day: the engine's trace, the changes of state, the battery's energies, the longest stays.

    `charging_s` is the time for which charging parts of waveforms lasted by their sheet, all pauses left out; the three
    times beside it are what the engine spent in each control while it charged. `missed` says in words which goal of the
    sheet was not reached, which phases never ran, and which were over as they began; empty where none.
    """

    trace: Mapping[str, Any]
    changes: list[Change]
    energy: Mapping[str, Any]
    charging_s: float
    current_limited_s: float
    voltage_limited_s: float
    supply_limited_s: float
    peak_temperature_c: float
    end_soc: float
    end_temperature_c: float
    charge_in_ah: float
    charge_out_ah: float
    steps: int
    missed: str


def charge_over_day(
    battery: Battery,
    mode: Mode,
    day: Surroundings,
    conditions: DayConditions,
    engine: EngineSettings,
) -> DayCharge:
    """Charge a battery over a day.

    The charger draws while the surplus lets it. A pause stops the clock of a phase: what the sheet asks to last an hour
    lasts an hour of charging. What was seen of the battery, a voltage's peak and readings of a sensor, is not carried
    over a pause, in which the current was lowered to nothing; a rule that has switched stays so. A charge that its
    sheet has ended stays ended; in place of the sheet's time limit stands the end of the day.

    Arguments
    ---------
    day : power and air.
    conditions : what the day begins from.

    Raises
    ------
    UserError : the mode does not fit the battery.
    EngineError : steps exhausted or a state without a solution.
    """
    air, interval_s = _air(day, conditions.ambient_step_s), conditions.sample_interval_s
    first_c = air[0][1] - ZERO_CELSIUS_K
    check(battery, mode, ChargeSettings(initial_soc=conditions.initial_soc, ambient_c=first_c))
    cell = compile_cell(battery)
    sheet = resolve(mode, battery.capacity_in_use_ah, battery.fills, battery.cells)
    run = resting_run(cell, conditions.initial_soc, air[0][1])
    start = run["state"].copy()
    spans = charging_spans(day.time_s, day.power_w, day.end_s, conditions.switching)
    cuts = sorted({0.0, day.end_s, *(edge for span in spans for edge in span), *(at_s for at_s, _ in air)})
    rows = math.ceil(day.end_s / interval_s) + 2 * len(cuts) + len(sheet.courses) + 4
    book = new_book(rows, rows, 0, np.zeros((0, 3)), np.zeros((0, 2)))
    book.peak_k[0] = start[TEMPERATURE]
    clock = new_clock(interval_s)
    sampled = any(isinstance(course.waveform, Sampled) for course in sheet.courses)
    alone = sampled or (day.kept_j is not None and any(shares(course)[2] > 0.0 for course in sheet.courses))
    control = compile_control(still_to_run(sheet, Place(), day.end_s), battery.capacity_in_use_ah)
    place, log = Place(), Log(conditions.switching)
    outcome = Outcome(cell, sheet, run, book, start, 0.0)
    for begin_s, until_s in pairwise(cuts):
        shines = next((span for span in spans if span.start_s <= begin_s < span.end_s), None)
        ambient_k = next(kelvin for at_s, kelvin in reversed(air) if at_s <= begin_s)
        while clock["time_s"] < until_s - TICK:
            begun, from_s = int(book.filled[1]), float(clock["time_s"])
            charging = shines is not None and not place.over
            if shines is not None and not place.over:
                resume(place, run, control)
                leg_s = min(whole_samples(sheet.courses[place.course], from_s, until_s), shines.end_s)
                leg = still_to_run(sheet, place, leg_s, alone)
            else:
                leg, place.paused = pause(until_s), True
            program = compile_program(leg, battery.cells_in_series, engine.driver, battery.cells_in_unit)
            supply = Supply(day.time_s, _lent(day, leg.courses[0]))
            if launch(cell, program, control, supply, run, book, clock, ambient_k, engine) != drive.DONE:
                raise EngineError(
                    f"the engine gave up at {clock['time_s']:.9g} s of the day, in a leg from {from_s:.9g} s"
                )
            outcome = replace(outcome, protocol=leg, end_s=float(clock["time_s"]))
            if charging:
                log.charged(outcome, sheet, place, begun)
            else:
                log.paused(from_s, place.over)
    end_soc = 1.0 - float(run["state"][DEPTH])
    return DayCharge(
        trace=trace(outcome, np.nan),
        changes=log.changes,
        energy=balance(cell, book.gains, start, run["state"], tuple(battery.pairs)),
        charging_s=log.charging_s,
        current_limited_s=float(book.totals[CURRENT_LIMITED_S]),
        voltage_limited_s=float(book.totals[VOLTAGE_LIMITED_S]),
        supply_limited_s=float(book.totals[SUPPLY_LIMITED_S]),
        charge_in_ah=float(book.totals[CHARGE_IN]) / 3600.0,
        charge_out_ah=float(book.totals[CHARGE_OUT]) / 3600.0,
        peak_temperature_c=float(book.peak_k[0]) - ZERO_CELSIUS_K,
        end_temperature_c=float(run["state"][TEMPERATURE]) - ZERO_CELSIUS_K,
        end_soc=end_soc,
        steps=int(run["steps"]),
        missed=missed(sheet, place, log, end_soc),
    )


def missed(sheet: Protocol, place: Place, log: Log, end_soc: float) -> str:
    """Return in words what a sheet asked for and a day did not bring.

    Arguments
    ---------
    place : where the charge stands at last light.
    log : what was noted of its legs.
    """
    wanted = goals(sheet)
    unmet = f"{either(wanted)} not reached by last light, SOC {end_soc:.4g}" if wanted and not place.over else ""
    skipped = [f"{name} skipped: {why}" for name, why in log.skipped.items() if name not in log.ran]
    parts = [unmet, log.missed_goal, never_ran(sheet, {*log.ran, *log.skipped}), *skipped]
    return "; ".join(part for part in parts if part)


def _lent(day: Surroundings, course: Course) -> Array:
    """Return the power of the supply during a pulse: that of the sun, and what the bus has kept of the pause before."""
    charging, _, pulses_hz = shares(course)
    if day.kept_j is None or pulses_hz == 0.0 or charging == 0.0:
        return day.power_w
    kept_j = np.minimum(day.power_w * (1.0 - charging) / pulses_hz, day.kept_j)
    return day.power_w + kept_j * pulses_hz / charging


def _air(day: Surroundings, step_s: float) -> list[tuple[float, float]]:
    """Return when the air around the battery changes, and to what [s], [K]: the mean of each step, changes alone."""
    starts = np.arange(0.0, day.end_s, step_s)
    edges = np.unique(np.concatenate([day.time_s, starts, [day.end_s]]))
    weights, middles = np.diff(edges), 0.5 * (edges[:-1] + edges[1:])
    values = held(day.time_s, day.ambient_c, middles)
    found: list[tuple[float, float]] = []
    for start_s in starts.tolist():
        mine = (middles > start_s) & (middles < start_s + step_s)
        same = np.ptp(values[mine]) == 0.0
        mean_c = float(values[mine][0]) if same else float(np.average(values[mine], weights=weights[mine]))
        if not found or found[-1][1] != mean_c + ZERO_CELSIUS_K:
            found.append((start_s, mean_c + ZERO_CELSIUS_K))
    return found


_REST = Course("rest", 0, Rest(), tuple(Rest().segments({})), None, {})
_SURPLUS = "surplus at least {:g} W"
_NO_SURPLUS = "surplus below {:g} W"
_DAWN = "first light"
_ROUNDING = 1e-9


@dataclass
class Place:
    """Where in its sheet a charge stands: the course, the time spent in the course's phase, why it is there or over.

    `begun` tells whether a leg has run a part of the course, `paused` whether a pause came after it.
    """

    course: int = 0
    used_s: float = 0.0
    begun: bool = False
    paused: bool = False
    why: str = ""
    over: str = ""


def still_to_run(sheet: Protocol, place: Place, until_s: float, alone: bool = False) -> Protocol:
    """Return the sheet from a place on, cut at a time of the day in place of its own time limit.

    Time spent in a phase before counts.

    Arguments
    ---------
    alone : return the course at the place alone.
    """
    group = sheet.courses[place.course].group
    courses = []
    for course in sheet.courses[place.course : place.course + 1 if alone else None]:
        until = dict(course.until)
        if course.group == group and "elapsed_s" in until:
            until["elapsed_s"] = max(0.0, until["elapsed_s"] - place.used_s)
        courses.append(replace(course, until=until))
    return replace(sheet, courses=tuple(courses), stop={**sheet.stop, "elapsed_s": until_s})


def resume(place: Place, run: Run, control: Control) -> None:
    """Let a leg go on where the one before it ended: what was seen of the battery holds on, but not over a pause."""
    run["resumed"] = place.begun
    if place.begun and place.paused:
        run["peak_v"], run["peak_a"] = NO_PEAK, 0.0
        interrupt(control)
    place.paused = False


def whole_samples(course: Course, from_s: float, until_s: float) -> float:
    """Return the end of the sample of a sampled course in which a time lies; the time itself for any other."""
    if not isinstance(course.waveform, Sampled):
        return until_s
    interval_s = course.values["sample_interval_s"]
    return from_s + interval_s * math.ceil((until_s - from_s) / interval_s - _ROUNDING)


def pause(until_s: float) -> Protocol:
    """Return a rest until a time of the day."""
    return Protocol((_REST,), {"elapsed_s": until_s})


@dataclass
class Log:
    """What is noted of the legs.

    Changes of state; the time for which the waveforms charged; names of the phases that ran, and of those over as they
    began with the reason; the goal that was not reached when the sheet ended the charge, in words.
    """

    switching: Switching
    changes: list[Change] = field(default_factory=list)
    charging_s: float = 0.0
    ran: set[str] = field(default_factory=set)
    skipped: dict[str, str] = field(default_factory=dict)
    missed_goal: str = ""

    def enter(self, time_s: float, state: str, why: str, course: Course | None = None) -> None:
        """Note that a state holds from a time on; nothing where it held before."""
        before = self.changes[-1].after if self.changes else OFF
        if state == before and self.changes:
            return
        charge, discharge, hertz = shares(course)
        self.changes.append(Change(time_s, before, state, why, closed(state, charge, discharge), hertz))

    def paused(self, time_s: float, over: str) -> None:
        """Note a leg without charging."""
        if over:
            self.enter(time_s, ENDED, over)
        else:
            told = _NO_SURPLUS.format(self.switching.stop_power_w) if self.changes else _DAWN
            self.enter(time_s, OFF, told)

    def charged(self, outcome: Outcome, sheet: Protocol, place: Place, begun: int) -> None:
        """Note a leg of charging, row by row of the book, and move on in the sheet.

        Arguments
        ---------
        outcome : the run, whose protocol is that of the leg.
        place : where the leg began; it becomes where the next one begins.
        begun : rows in the book before the leg.
        """
        rows = outcome.book.phases[begun : outcome.book.filled[1]]
        first = place.course
        why = place.why or _SURPLUS.format(self.switching.start_power_w)
        # A phase is said to end after the time its sheet gives it, not after what a pause left of that.
        asked = replace(outcome, protocol=replace(outcome.protocol, courses=sheet.courses[first:]))
        group, spent_s = sheet.courses[first].group, place.used_s
        for number, row in enumerate(rows):
            course = sheet.courses[first + int(row[7])]
            if course.group != group:
                group, spent_s = course.group, 0.0
            length_s = float(row[2] - row[1])
            spent_s += length_s
            if length_s > 0.0:
                self.charging_s += length_s * shares(course)[0]
                self.enter(float(row[1]), MODE_2 if course.waveform.periodic else MODE_1, why, course)
            why = reason(asked, begun + number)
            if length_s > 0.0:
                self.ran.add(course.name)
            elif int(row[3]) < LIMITS or int(row[3]) >= EDGE:
                self.skipped.setdefault(course.name, f"{why}, met as it began")
            place.course, place.used_s = first + int(row[7]), spent_s
        code = int(rows[-1][3])
        place.why, place.begun = "", code == LIMITS + ELAPSED
        if place.begun:
            return
        following = place.course + 1
        while code != EDGE and following < len(sheet.courses) and sheet.courses[following].group == group:
            following += 1
        if LIMITS <= code < EDGE or following == len(sheet.courses):
            place.over, self.missed_goal = why, missed_goal(asked)
            self.enter(outcome.end_s, ENDED, why)
            return
        place.why, place.course = why, following
        place.used_s = spent_s if sheet.courses[following].group == group else 0.0


def shares(course: Course | None) -> tuple[float, float, float]:
    """Return the shares of charging and discharging of a course's period, and its frequency [Hz]; 0 without pulses."""
    if course is None or not course.waveform.periodic:
        return 1.0, 0.0, 0.0
    period_s = sum(segment.length_s for segment in course.segments)
    if not math.isfinite(period_s):
        return 1.0, 0.0, 0.0
    charge = sum(segment.length_s for segment in course.segments if segment.charging) / period_s
    discharge = sum(segment.length_s for segment in course.segments if segment.current_a < 0.0) / period_s
    return charge, discharge, 1.0 / period_s
