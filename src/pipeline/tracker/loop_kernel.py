"""The closed loop of tracker, boost converter and panel over rows of constant light, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined, kernel
from pipeline.tracker.algorithms import (
    constant_voltage,
    incremental_conductance,
    particle_swarm,
    perturb_observe,
    variable_step,
)
from pipeline.tracker.circuit_kernel import FIRST_STEP_S, GROWTH, circuit_step, panel_current, tabled_current

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
