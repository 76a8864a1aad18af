"""A tracker in closed loop through the boost converter over rows of constant light, and what it captures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import UserError
from pipeline.jit import inlined, kernel
from pipeline.tracker.algorithms import (
    constant_voltage,
    incremental_conductance,
    particle_swarm,
    perturb_observe,
    variable_step,
)
from pipeline.tracker.records import (
    AnyTracker,
    ConstantVoltage,
    IncrementalConductance,
    ParticleSwarm,
    PerturbObserve,
    first_duty,
)
from pipeline.tracker.source import (
    FIRST_STEP_S,
    GROWTH,
    Source,
    available_power_w,
    circuit_step,
    of_all_panels,
    panel_current,
    parts,
    scales,
    tabled_current,
)

Array = NDArray[np.float64]
Places = NDArray[np.int64]

KINDS = ("perturb_observe", "incremental_conductance", "variable_step", "constant_voltage", "particle_swarm")
"""Every tracker by the number under which the loop knows it."""
_perturb, _increment, _vary = perturb_observe.decide, incremental_conductance.decide, variable_step.decide
_hold, _swarm = constant_voltage.decide, particle_swarm.decide
_ROUNDING = 1e-9
_SHORTEST_S = 1e-7
_REACH = 1.0
_TABLED_REACH_STEPS = 20.0
"""How far the panel's voltage may move in a step: idealities, or steps of the tabled curve."""


@inlined
def _decide(kind: int, voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    if kind == 0:
        return _perturb(voltage, current, duty, memory, own)
    if kind == 1:
        return _increment(voltage, current, duty, memory, own)
    if kind == 2:
        return _vary(voltage, current, duty, memory, own)
    if kind == 3:
        return _hold(voltage, current, duty, memory, own)
    return _swarm(voltage, current, duty, memory, own)


@kernel
def run_loop(
    kind: int,
    own: Array,
    control: Array,
    memory: Array,
    parts: Array,
    length: Array,
    diode: Array,
    series: float,
    curves: Array,
    curve_step: float,
    which: Places,
    state: Array,
    energy: Array,
    ends: Array,
) -> None:
    """Run the loop.

    Arguments
    ---------
    kind : place in `KINDS`; own : its `numbers`; memory : what it remembers, zeros at first.
    control : perturbation period [s], resolution of the voltage [V] and of the current [A], then
        least, largest and first duty.
    parts : values of the circuit.
    length : of each row [s], shape (n,).
    diode : photocurrent, saturation current, shunt conductance, ideality of all panels in each row, shape (4, n).
    series : their series resistance [ohm].
    curves, curve_step, which : tabled curves, their step [V], and the one of each row; below zero: `diode`.
    state : panel voltage, inductor current, duty, time to the next measurement, diode voltage; changed.
    energy : energy from the panel in each row [J], filled in, shape (n,).
    ends : panel voltage, current, duty at the end of each row, filled in, shape (3, n).
    """
    voltage, inductor, duty, waiting, inside = state[0], state[1], state[2], state[3], state[4]
    for row in range(length.shape[0]):
        place, left, got = which[row], length[row], 0.0
        dark = place < 0 and diode[0, row] <= 0.0
        if dark:
            voltage, inductor, inside, duty = 0.0, 0.0, 0.0, control[5]
            waiting = max(waiting - left, 0.0)
            left = 0.0
        current, conductance, reach = 0.0, 0.0, _TABLED_REACH_STEPS * curve_step
        if not dark:
            if place >= 0:
                current, conductance = tabled_current(curves[place], curve_step, voltage)
            else:
                reach = _REACH * diode[3, row]
                current, conductance, inside = panel_current(
                    diode[0, row], diode[1, row], diode[2, row], diode[3, row], series, voltage, inside
                )
        while left > _ROUNDING:
            span, step = min(left, waiting), FIRST_STEP_S
            gone = 0.0
            while gone < span - _ROUNDING:
                step = span - gone if span - gone < 1.5 * step else step
                before = voltage * current
                new_v, new_a = circuit_step(voltage, inductor, current, conductance, duty, parts, step)
                while abs(new_v - voltage) > reach and step > _SHORTEST_S:
                    step *= 0.25
                    new_v, new_a = circuit_step(voltage, inductor, current, conductance, duty, parts, step)
                inside += (new_v - voltage) * (1.0 - series * conductance)
                voltage, inductor = new_v, new_a
                if place >= 0:
                    current, conductance = tabled_current(curves[place], curve_step, voltage)
                else:
                    current, conductance, inside = panel_current(
                        diode[0, row], diode[1, row], diode[2, row], diode[3, row], series, voltage, inside
                    )
                got += 0.5 * step * (before + voltage * current)
                gone += step
                step *= GROWTH
            left -= span
            waiting -= span
            if waiting <= _ROUNDING:
                seen_v = np.floor(voltage / control[1] + 0.5) * control[1]
                seen_a = np.floor(current / control[2] + 0.5) * control[2]
                asked = _decide(kind, seen_v, seen_a, duty, memory, own)
                duty = min(max(asked, control[3]), control[4])
                waiting = control[0]
        energy[row] = got
        ends[0, row], ends[1, row], ends[2, row] = voltage, current, duty
    state[0], state[1], state[2], state[3], state[4] = voltage, inductor, duty, waiting, inside


FULL_SCALE = 1.25
"""Full scale of the measurements over V_oc and I_sc of the data sheet."""
_MEMORY = 4


class Light(NamedTuple):
    """What the panels give in each row: single-diode parameters, or the number of a tabled curve.

    Arguments
    ---------
    length_s : length of each row [s], shape (n,).
    diode : photocurrent, saturation current, shunt conductance, ideality of all panels, shape (4, n).
    series_resistance_ohm : of all panels.
    curves : currents of tabled curves [A], shape (k, m).
    curve_step_v : distance of their voltages, the first of which is 0 [V].
    which : the curve of each row, below zero for `diode`, shape (n,).
    """

    length_s: Array
    diode: Array
    series_resistance_ohm: float
    curves: Array
    curve_step_v: float
    which: NDArray[np.int64]


class Course(NamedTuple):
    """What a tracker made of each row: energy from the panels [J]; voltage, current and duty at its end; shape (n,)."""

    energy_j: Array
    voltage_v: Array
    current_a: Array
    duty: Array


def run(source: Source, tracker: AnyTracker, light: Light, start_voltage_v: float | None = None) -> Course:
    """Run a tracker.

    Arguments
    ---------
    start_voltage_v : voltage of the panels at the start, V_oc of the data sheet without, and no current [V].
    """
    size = scales(source)
    resolution = FULL_SCALE / (2.0**tracker.measurement_bits - 1.0)
    control = np.array(
        [
            tracker.perturbation_period_s,
            resolution * size.open_circuit_voltage_v,
            resolution * size.short_circuit_current_a,
            tracker.least_duty,
            tracker.most_duty,
            first_duty(tracker, size),
        ]
    )
    voltage = size.open_circuit_voltage_v if start_voltage_v is None else start_voltage_v
    state = np.array([voltage, 0.0, control[5], tracker.perturbation_period_s, voltage])
    rows = len(light.length_s)
    energy, ends = np.empty(rows), np.empty((3, rows))
    run_loop(
        KINDS.index(tracker.kind),
        np.array(_numbers(tracker, source)),
        control,
        np.zeros(particle_swarm.memory_size(tracker) if isinstance(tracker, ParticleSwarm) else _MEMORY),
        parts(source),
        np.ascontiguousarray(light.length_s, dtype=np.float64),
        np.ascontiguousarray(light.diode),
        float(light.series_resistance_ohm),
        np.ascontiguousarray(light.curves),
        float(light.curve_step_v),
        light.which,
        state,
        energy,
        ends,
    )
    return Course(energy, ends[0], ends[1], ends[2])


def _numbers(tracker: AnyTracker, source: Source) -> list[float]:
    size = scales(source)
    if isinstance(tracker, PerturbObserve):
        return perturb_observe.numbers(tracker, size)
    if isinstance(tracker, IncrementalConductance):
        return incremental_conductance.numbers(tracker, size)
    if isinstance(tracker, ConstantVoltage):
        return constant_voltage.numbers(tracker, size)
    if isinstance(tracker, ParticleSwarm):
        return particle_swarm.numbers(tracker, size)
    return variable_step.numbers(tracker, size)


__all__ = ["Source", "available", "capture", "course", "light"]


def capture(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Array:
    """Return the mean power a tracker draws from the panels over each interval.

    The tracker starts with the panels at open circuit. In the dark it draws nothing and keeps its duty.

    Arguments
    ---------
    source : panels, boost converter and bus.
    tracker : its record.
    time_s : starts of the intervals over which the weather is constant, rising [s], shape (n,); the last interval is
        as long as the one before it, a single one a perturbation period.
    irradiance_w_m2, cell_temperature_c : the weather in each interval [W/m2], [degC], shape (n,) or one for all.

    Returns
    -------
    Captured power [W], shape (n,).

    Raises
    ------
    UserError : times that do not rise, an irradiance below zero, a number that is not finite.
    """
    rows = light(source, tracker, time_s, irradiance_w_m2, cell_temperature_c)
    return run(source, tracker, rows).energy_j / rows.length_s


def available(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> Array:
    """Return the maximum power of the panels in each interval [W], shape (n,); arguments as for `capture`."""
    return available_power_w(source, irradiance_w_m2, cell_temperature_c)


def course(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Course:
    """Return energy, and voltage, current and duty at the end of each interval; arguments as for `capture`."""
    return run(source, tracker, light(source, tracker, time_s, irradiance_w_m2, cell_temperature_c))


def light(
    source: Source, tracker: AnyTracker, time_s: ArrayLike, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike
) -> Light:
    """Return the weather as the closed loop takes it; arguments as for `capture`."""
    time = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
    if not time.size:
        raise UserError("time_s: no rows; at least one is needed")
    length = np.diff(time)
    wrong = ~(length > 0.0)
    if wrong.any():
        place = int(np.argmax(wrong))
        raise UserError(
            f"time_s: row {place + 1} is {time[place + 1]:g} s after {time[place]:g} s; each time must be later than "
            "the one before it"
        )
    length = np.append(length, length[-1] if length.size else tracker.perturbation_period_s)
    irradiance, temperature = (
        np.broadcast_to(np.asarray(part, dtype=np.float64), time.shape)
        for part in (irradiance_w_m2, cell_temperature_c)
    )
    diode, series = of_all_panels(source, irradiance, temperature)
    return Light(length, diode, series, np.zeros((1, 2)), 1.0, np.full(time.shape, -1, dtype=np.int64))
