"""Legs of a day: the part of a mode's sheet that is still to be run, and what is noted of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from pipeline.bus.flows import ENDED, MODE_1, MODE_2, OFF, Change, closed
from pipeline.bus.records import Switching
from pipeline.charge.controller import Control, interrupt
from pipeline.charge.outcome import Outcome, reason
from pipeline.charge.protocol import Course, Protocol
from pipeline.charge.segment import EDGE, ELAPSED, LIMITS
from pipeline.charge.state import Run
from pipeline.charge.watching import NO_PEAK
from pipeline.charge.waveforms import Rest, Sampled

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
    return Protocol(tuple(courses), {**sheet.stop, "elapsed_s": until_s})


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
    """What is noted of the legs: changes of state, and the time for which the waveforms charged."""

    switching: Switching
    changes: list[Change] = field(default_factory=list)
    charging_s: float = 0.0

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
        asked = replace(outcome, protocol=Protocol(sheet.courses[first:], outcome.protocol.stop))
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
            place.course, place.used_s = first + int(row[7]), spent_s
        code = int(rows[-1][3])
        place.why, place.begun = "", code == LIMITS + ELAPSED
        if place.begun:
            return
        following = place.course + 1
        while code != EDGE and following < len(sheet.courses) and sheet.courses[following].group == group:
            following += 1
        if LIMITS <= code < EDGE or following == len(sheet.courses):
            place.over = why
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
