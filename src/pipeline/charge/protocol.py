"""From a lab sheet to numbers: every reference to a knob replaced, every phase a list of segments."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.charge.records import Mode, Phase
from pipeline.charge.waveforms import PER_CAPACITY, Segment, Staged, Waveform, of_battery, spellings
from pipeline.errors import UserError, best_matches
from pipeline.record import Number, Record, Reference

C_RATE = "_c_rate"
# Beyond it a current has the wrong unit: no charger goes there. One without a limit stops there.
MOST_C_RATE = 100.0
UNTIL = ("elapsed_s", "soc", "voltage_v", "current_a", "temperature_c", "voltage_drop_v", "temperature_rate_k_s")


@dataclass(frozen=True)
class Course:
    """A phase in numbers; `group` counts the phases of the sheet as they are run, a stage each being a course.

    `values` are the waveform's parameters.
    """

    name: str
    group: int
    waveform: Waveform
    segments: tuple[Segment, ...]
    limit_v: float | None
    until: Mapping[str, float]
    edge_soc: float | None = None
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Lift:
    """What the battery's temperature adds to every voltage of a sheet that is held, not exceeded or reached.

    `v_per_k_cell (T - reference_c)` per cell, T no lower than `lowest_c` and no higher than `highest_c`.
    """

    v_per_k_cell: float = 0.0
    reference_c: float = 25.0
    lowest_c: float = -math.inf
    highest_c: float = math.inf

    def per_cell_v(self, temperature_c: float) -> float:
        """Return what is added for one cell [V]."""
        return self.v_per_k_cell * (min(max(temperature_c, self.lowest_c), self.highest_c) - self.reference_c)


def lift_of(mode: Mode) -> Lift:
    """Return what temperature does to the voltages of a mode."""
    if mode.temperature_coefficient_v_per_k_cell is None:
        return Lift()
    low, high = mode.lowest_compensated_c, mode.highest_compensated_c
    return Lift(
        mode.temperature_coefficient_v_per_k_cell,
        mode.reference_temperature_c,
        -math.inf if low is None else low,
        math.inf if high is None else high,
    )


@dataclass(frozen=True)
class Protocol:
    """A mode in numbers, for one battery; `built_in` names the stops that are the model's and not the sheet's."""

    courses: tuple[Course, ...]
    stop: Mapping[str, float]
    built_in: frozenset[str] = frozenset()
    lift: Lift = field(default_factory=Lift)


class Resolver:
    """Looks up knobs and keeps note of those used."""

    def __init__(self, mode: Mode, capacity_in_use_ah: float, cells: int | None = None) -> None:
        """Take the knobs of a mode.

        Arguments
        ---------
        capacity_in_use_ah : for what is given as a C-rate [A h].
        cells : cells in series, for what is given per cell; none where nobody asks for a voltage.
        """
        self.knobs = mode.knobs
        self.capacity_in_use_ah = capacity_in_use_ah
        self.cells = cells
        self.used: set[str] = set()
        self._looked_up: dict[tuple[int, str], Mapping[str, Number]] = {}

    def holds(self, name: str) -> bool:
        """Tell whether a parameter has a knob of its own name."""
        return any(key in self.knobs for key in spellings(name))

    def number(self, value: Any, name: str, where: str) -> Number | None:
        """Return the number behind a parameter; a reference that is still open comes back as it is.

        Arguments
        ---------
        value : number, name of a knob, or None for the knob called `name`.
        name : of the parameter; with an ending of `SCALED`, a number or a plain knob is multiplied.
        where : key path, for the message.

        Raises
        ------
        UserError : no such knob.
        """
        own, per = of_battery(name)
        if isinstance(value, float | int):
            return self._scaled(float(value), per)
        wanted = own if value is None else value
        for key in spellings(wanted):
            if key in self.knobs:
                self.used.add(key)
                knob = self.knobs[key]
                return knob if isinstance(knob, Reference) else self._scaled(knob, of_battery(key)[1] or per)
        names = " or ".join(spellings(wanted))
        said = f"not given, and the mode has no knob {names}" if value is None else f"names the knob {wanted!r}"
        near = f"; {best_matches(wanted, self.knobs)}" if self.knobs else ""
        raise UserError(f"{where}: {said}{near}")

    def _scaled(self, number: float, per: str | None) -> float:
        if per is None:
            return number
        if per == PER_CAPACITY:
            return number * self.capacity_in_use_ah
        if self.cells is None:
            raise ValueError("a voltage per cell needs the number of cells")
        return number * self.cells

    def once(self, record: Record, where: str, look_up: Callable[[], Mapping[str, Number]]) -> Mapping[str, Number]:
        """Return the numbers of a part of the mode, looked up once."""
        if (id(record), where) not in self._looked_up:
            self._looked_up[id(record), where] = look_up()
        return self._looked_up[id(record), where]

    def optional(self, record: Record, where: str) -> Mapping[str, Number]:
        """Return the numbers of those fields of a record that are given, by their names for a whole battery."""
        return self.once(record, where, lambda: self._optional(record, where))

    def _optional(self, record: Record, where: str) -> dict[str, Number]:
        given = {name: value for name, value in record if value is not None}
        found = {of_battery(name)[0]: self.number(value, name, f"{where}.{name}") for name, value in given.items()}
        return {name: value for name, value in found.items() if value is not None}


def parameters(resolver: Resolver, waveform: Waveform, where: str) -> Mapping[str, Number]:
    """Return a waveform's parameters as numbers; those of a list are called `name.0`, `name.1`, ...

    A reference that is still open comes back as it is, one for a whole list under the name of the list.
    """
    return resolver.once(waveform, where, lambda: _parameters(resolver, waveform, where))


def _parameters(resolver: Resolver, waveform: Waveform, where: str) -> dict[str, Number]:
    found: dict[str, Number | None] = {}
    for name, value in waveform:
        if name in waveform.no_parameters:
            continue
        if isinstance(value, list):
            found |= {f"{name}.{n}": resolver.number(v, name, f"{where}.{name}.{n}") for n, v in enumerate(value)}
        elif isinstance(value, Reference):
            found[name] = value
        elif value is None and name in waveform.optional and not resolver.holds(name):
            found[name] = min(waveform.optional[name], MOST_C_RATE * resolver.capacity_in_use_ah)
        else:
            found[name] = resolver.number(value, name, f"{where}.{name}")
    return {name: value for name, value in found.items() if value is not None}


def resolve(mode: Mode, capacity_in_use_ah: float, fills: bool = False, cells: int | None = None) -> Protocol:
    """Return a mode in numbers.

    Arguments
    ---------
    capacity_in_use_ah : for what is given as a C-rate [A h].
    fills : nothing in the battery keeps it below SOC 1, so that the charge must stop there.
    cells : cells in series, for what is given per cell; may be left out where nothing is.

    Raises
    ------
    UserError : a parameter without a value, a name that is no knob, or a reference that is still open.
    """
    resolver = Resolver(mode, capacity_in_use_ah, cells)
    once: list[list[Course]] = []
    for name, phase in mode.phases.items():
        once.append(_courses(resolver, name, phase))
    courses = []
    for turn in range(mode.repeat):
        for place, group in enumerate(once):
            number = turn * len(once) + place
            courses += [replace(course, group=number) for course in group]
    stop = _closed(resolver.optional(mode.stop, "stop"), "stop")
    lift = lift_of(mode)
    if fills and "soc" not in stop:
        return Protocol(tuple(courses), {"soc": 1.0} | stop, frozenset({"soc"}), lift)
    return Protocol(tuple(courses), stop, lift=lift)


def _courses(resolver: Resolver, name: str, phase: Phase) -> list[Course]:
    where = f"phases.{name}"
    values = _closed(parameters(resolver, phase.waveform, where), where)
    segments = tuple(phase.waveform.segments(values))
    limit = _closed(resolver.optional(phase.limit, f"{where}.limit"), f"{where}.limit").get("voltage_v")
    if phase.waveform.holds_voltage:
        limit = values["voltage_v"] if limit is None else min(limit, values["voltage_v"])
    until = _closed(resolver.optional(phase.until, f"{where}.until"), f"{where}.until")
    if not isinstance(phase.waveform, Staged):
        return [Course(name, 0, phase.waveform, segments, limit, until, values=values)]
    return [
        Course(f"{name} {n + 1}", 0, phase.waveform, (segment,), limit, until, edge, values)
        for n, (segment, edge) in enumerate(zip(segments, phase.waveform.soc_edges, strict=True))
    ]


def _closed(values: Mapping[str, Number], where: str) -> dict[str, float]:
    numbers = {}
    for name, value in values.items():
        if isinstance(value, Reference):
            raise UserError(f"{where}.{name}: still to be found by {value.source!r}; put the number in first")
        numbers[name] = value
    return numbers
