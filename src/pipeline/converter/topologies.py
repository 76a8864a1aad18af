"""The linear circuits that the switches of a converter make in turn, as matrices over (currents, voltages, 1).

The state is (inductor current, output capacitor's voltage, a third voltage, 1): of the battery's fast pair behind a
buck converter, of the capacitor across the panel before a boost converter. The one carries the sources.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.records import SwitchedBoost, SwitchedBuck

Array = NDArray[np.float64]

SIZE = 4
INDUCTOR, CAPACITOR, THIRD, ONE = range(SIZE)
ON, LOW, DIODE, BLOCKED, RETURN, DISCHARGE = range(6)
"""Switch on; second switch on, or a diode; no inductor current; back into the source; resistor on the battery."""


class BatteryLoad(NamedTuple):
    """A battery for some milliseconds: everything slower than its fastest pair stands still.

    The voltage is open-circuit voltage and slow pairs together.
    """

    voltage_v: float
    series_resistance_ohm: float
    pair_resistance_ohm: float
    pair_time_constant_s: float


class PanelSource(NamedTuple):
    """A panel near its maximum power, as its tangent there: voltage without current, and resistance."""

    voltage_v: float
    resistance_ohm: float


class Topologies(NamedTuple):
    """Generators G of dz/dt = G z, shape (6, 4, 4), and rows that read two outputs from z, shape (6, 2, 4).

    The outputs of a buck converter are battery current [A] and terminal voltage [V], of a boost converter the current
    into the bus and the bus voltage; a boost converter's last two circuits stay empty.
    """

    generators: Array
    outputs: Array


def buck(stage: SwitchedBuck, bus_voltage_v: float, load: BatteryLoad, discharge_resistance_ohm: float) -> Topologies:
    """Return the circuits of a buck converter that charges a battery.

    Arguments
    ---------
    stage : its parts.
    bus_voltage_v : voltage it is fed with [V].
    load : the battery.
    discharge_resistance_ohm : resistor that S4 puts across the battery [ohm].
    """
    generators, outputs = np.zeros((6, SIZE, SIZE)), np.zeros((6, 2, SIZE))
    inductor, one = np.eye(SIZE)[INDUCTOR], np.eye(SIZE)[ONE]
    drops = {
        ON: bus_voltage_v * one - stage.on_resistance_ohm * inductor,
        LOW: -stage.rectifier_resistance_ohm * inductor,
        DIODE: -stage.rectifier_voltage_v * one - stage.rectifier_resistance_ohm * inductor,
        RETURN: (bus_voltage_v + stage.rectifier_voltage_v) * one - stage.on_resistance_ohm * inductor,
    }
    for topology in range(6):
        connected = topology != DISCHARGE or not stage.isolates_discharge
        resistor_ohm = discharge_resistance_ohm if topology == DISCHARGE else np.inf
        node, current = _output(stage, load, resistor_ohm, connected)
        into_capacitor = (node - np.eye(SIZE)[CAPACITOR]) / stage.capacitor_resistance_ohm
        rows = generators[topology]
        if topology in drops:
            voltage = drops[topology] - stage.inductor_resistance_ohm * inductor - node
            rows[INDUCTOR] = voltage / stage.inductance_h
        rows[CAPACITOR] = into_capacitor / stage.capacitance_f
        rows[THIRD] = load.pair_resistance_ohm / load.pair_time_constant_s * current
        rows[THIRD, THIRD] -= 1.0 / load.pair_time_constant_s
        outputs[topology] = [current, _battery(load) + load.series_resistance_ohm * current]
    return Topologies(generators, outputs)


def boost(stage: SwitchedBoost, source: PanelSource, bus_resistance_ohm: float) -> Topologies:
    """Return the circuits of a boost converter between a panel and a bus.

    Arguments
    ---------
    stage : its parts.
    source : the panel.
    bus_resistance_ohm : what draws from the bus, as its voltage over its current [ohm].
    """
    generators, outputs = np.zeros((6, SIZE, SIZE)), np.zeros((6, 2, SIZE))
    inductor, capacitor, panel, one = np.eye(SIZE)
    for topology in (ON, LOW, DIODE, BLOCKED):
        passed = inductor if topology in (LOW, DIODE) else np.zeros(SIZE)
        bus = (capacitor + stage.capacitor_resistance_ohm * passed) / (
            1.0 + stage.capacitor_resistance_ohm / bus_resistance_ohm
        )
        drops = {
            ON: stage.on_resistance_ohm * inductor,
            LOW: bus + stage.rectifier_resistance_ohm * inductor,
            DIODE: bus + stage.rectifier_resistance_ohm * inductor + stage.rectifier_voltage_v * one,
        }
        rows = generators[topology]
        if topology in drops:
            left = panel - stage.inductor_resistance_ohm * inductor - drops[topology]
            rows[INDUCTOR] = left / stage.inductance_h
        rows[CAPACITOR] = (passed - bus / bus_resistance_ohm) / stage.capacitance_f
        drawn = inductor if topology != BLOCKED else np.zeros(SIZE)
        rows[THIRD] = ((source.voltage_v * one - panel) / source.resistance_ohm - drawn) / stage.input_capacitance_f
        outputs[topology] = [passed, bus]
    return Topologies(generators, outputs)


def _battery(load: BatteryLoad) -> Array:
    return np.asarray(load.voltage_v * np.eye(SIZE)[ONE] + np.eye(SIZE)[THIRD])


def _output(stage: SwitchedBuck, load: BatteryLoad, resistor_ohm: float, connected: bool) -> tuple[Array, Array]:
    """Return the rows of the converter's output voltage and of the battery's current, from Kirchhoff's laws."""
    inductor, capacitor, _, _ = np.eye(SIZE)
    battery_s = 1.0 / load.series_resistance_ohm
    if not connected:
        return capacitor + stage.capacitor_resistance_ohm * inductor, -_battery(load) / (
            resistor_ohm + load.series_resistance_ohm
        )
    capacitor_s = 1.0 / stage.capacitor_resistance_ohm
    total_s = capacitor_s + battery_s + 1.0 / resistor_ohm
    node = (capacitor_s * capacitor + battery_s * _battery(load) + inductor) / total_s
    return node, battery_s * (node - _battery(load))


SERIES_REACH = 0.1
"""Norm of G t up to which ten terms of the exponential's series leave less than rounding."""


class Maps(NamedTuple):
    """What the kernel needs of each circuit.

    Arguments
    ---------
    generators : G of dz/dt = G z, shape (n, 4, 4).
    steps, sums : exp(G t), and its integral over t, for t = 0, tick, ... up to one sample, shape (n, m + 1, 4, 4).
    tick_s : sample over m; a series bridges what is left of a tick [s].
    sample_s, samples : distance of the samples [s], and how many there are in a switching period.
    outputs : rows that read the outputs, shape (n, 2, 4).
    """

    generators: Array
    steps: Array
    sums: Array
    tick_s: float
    sample_s: float
    samples: int
    outputs: Array


def exponential(generator: Array, length_s: float) -> tuple[Array, Array]:
    """Return exp(G t) and its integral from 0 to t, by one exponential of the doubled system (Van Loan 1978).

    DOI 10.1109/TAC.1978.1101743.
    """
    from scipy.linalg import expm

    size = len(generator)
    doubled = np.zeros((2 * size, 2 * size))
    doubled[:size, :size] = generator * length_s
    doubled[:size, size:] = np.eye(size) * length_s
    found = expm(doubled)
    return found[:size, :size], found[:size, size:]


def maps(topologies: Topologies, period_s: float, samples: int) -> Maps:
    """Return the maps of all circuits.

    Arguments
    ---------
    topologies : generators and outputs.
    period_s : length of a switching period [s].
    samples : samples of a switching period.
    """
    sample_s = period_s / samples
    norm = float(np.abs(topologies.generators).sum(axis=2).max())
    ticks = max(1, math.ceil(norm * sample_s / SERIES_REACH))
    count = len(topologies.generators)
    steps, sums = np.zeros((2, count, ticks + 1, SIZE, SIZE))
    for place, generator in enumerate(topologies.generators):
        step, integral = exponential(generator, sample_s / ticks)
        steps[place, 0] = np.eye(SIZE)
        for tick in range(ticks):
            steps[place, tick + 1] = step @ steps[place, tick]
            sums[place, tick + 1] = sums[place, tick] + integral @ steps[place, tick]
    return Maps(topologies.generators, steps, sums, sample_s / ticks, sample_s, samples, topologies.outputs)
