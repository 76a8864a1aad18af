"""A tracker in closed loop through the boost converter, over rows of constant light."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.tracker.algorithms import (
    constant_voltage,
    incremental_conductance,
    particle_swarm,
    perturb_observe,
    variable_step,
)
from pipeline.tracker.loop_kernel import KINDS, run_loop
from pipeline.tracker.records import (
    AnyTracker,
    ConstantVoltage,
    IncrementalConductance,
    ParticleSwarm,
    PerturbObserve,
)
from pipeline.tracker.scales import first_duty
from pipeline.tracker.source import Source, parts, scales

Array = NDArray[np.float64]

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
