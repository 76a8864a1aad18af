"""A charge over a day: the engine from one switching to the next, its state carried on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.flows import Change, charging_spans
from pipeline.bus.load import held
from pipeline.cell.circuit import ZERO_CELSIUS_K, compile_cell
from pipeline.cell.records import Battery
from pipeline.charge import drive
from pipeline.charge.checks import check
from pipeline.charge.controller import compile_control
from pipeline.charge.energy import balance
from pipeline.charge.outcome import Outcome, trace
from pipeline.charge.period import TICK, new_clock
from pipeline.charge.program import compile_program
from pipeline.charge.protocol import Course, resolve
from pipeline.charge.record_keeping import (
    CHARGE_IN,
    CHARGE_OUT,
    CURRENT_LIMITED_S,
    SUPPLY_LIMITED_S,
    VOLTAGE_LIMITED_S,
)
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, launch, new_book, resting_run
from pipeline.charge.state import DEPTH, TEMPERATURE
from pipeline.charge.waveforms import Sampled
from pipeline.day.legs import Log, Place, pause, resume, shares, still_to_run, whole_samples
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
    times beside it are what the engine spent in each control while it charged.
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
    sheet = resolve(mode, battery.capacity_in_use_ah, battery.fills)
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
            program = compile_program(leg, battery.cells_in_series, engine.driver)
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
        end_soc=1.0 - float(run["state"][DEPTH]),
        steps=int(run["steps"]),
    )


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
