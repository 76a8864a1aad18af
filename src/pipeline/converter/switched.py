"""A converter switch by switch: exact from one switching instant to the next.

The boost converter runs at a duty that its tracker sets, the buck converter under its current control: in each period
the duty is the battery's voltage over the bus voltage, as the mean of the period before gave it, plus a proportional
and an integral part of the reference less the mean inductor current of that period. The integral stands still while the
duty is at a limit and between the pulses. A reference of zero turns the switch off: the second switch carries the
current as a diode until it is zero. A negative one does the same, and then lets a resistor discharge the battery (S4).
References change with the switching periods.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.records import SwitchedBoost, SwitchedBuck
from pipeline.converter.switched_kernel import PERIOD_COLUMNS, run_periods
from pipeline.converter.topologies import (
    CAPACITOR,
    INDUCTOR,
    ONE,
    SIZE,
    THIRD,
    BatteryLoad,
    Maps,
    PanelSource,
    boost,
    buck,
    maps,
)

Array = NDArray[np.float64]


class Gains(NamedTuple):
    """The control in numbers: duty per ampere, duty per ampere and period, largest duty, bus voltage."""

    proportional_per_a: float
    integral_per_a: float
    most_duty: float
    bus_voltage_v: float


class SwitchedRun(NamedTuple):
    """What a run left.

    Arguments
    ---------
    samples : inductor current, battery current [A], terminal voltage [V] at the start of the run and then
        `samples_per_period` times a period, shape (3, n samples + 1).
    periods : column -> a value per switching period, shape (n,); `PERIOD_COLUMNS` names them.
    """

    samples: Array
    periods: dict[str, Array]


def gains(stage: SwitchedBuck, bus_voltage_v: float) -> Gains:
    """Return the control's gains: with inductor and bus voltage alone the loop has the crossover it asks for."""
    proportional = 2.0 * np.pi * stage.control.crossover_hz * stage.inductance_h / bus_voltage_v
    integral = proportional * 2.0 * np.pi * stage.control.zero_hz * stage.switching_period_s
    return Gains(proportional, integral, stage.control.most_duty, bus_voltage_v)


def run_buck(
    stage: SwitchedBuck,
    bus_voltage_v: float,
    load: BatteryLoad,
    reference_a: Array,
    pair_voltage_v: float,
    samples: int = 20,
    discharge_resistance_ohm: float = np.inf,
) -> SwitchedRun:
    """Run the converter over some switching periods.

    Arguments
    ---------
    reference_a : mean inductor current asked for in each period; 0: off; negative: the resistor is on, shape (n,) [A].
    pair_voltage_v : voltage of the battery's fast pair at the start [V].
    samples : samples of each period.
    discharge_resistance_ohm : resistor behind S4 [ohm].

    Returns
    -------
    Samples and periods. The run starts as if the first reference had been there all along.
    """
    made = maps(buck(stage, bus_voltage_v, load, discharge_resistance_ohm), stage.switching_period_s, samples)
    reference = np.ascontiguousarray(reference_a, dtype=np.float64)
    state, memory = start(stage, bus_voltage_v, load, float(reference[0]), pair_voltage_v)
    return follow(made, gains(stage, bus_voltage_v), stage.rectifier == "synchronous", reference, state, memory)


def run_boost(
    stage: SwitchedBoost,
    source: PanelSource,
    bus_resistance_ohm: float,
    duty: float,
    state: Array,
    periods: int,
    samples: int = 20,
) -> SwitchedRun:
    """Run a boost converter at a fixed duty over some switching periods, its current continuous or not.

    Arguments
    ---------
    source : the panel.
    bus_resistance_ohm : what draws from the bus, as its voltage over its current [ohm].
    duty : share of each period for which the switch is on [1].
    state : inductor current [A], voltages of the output capacitor and across the panel [V] at the start, shape (3,).
    samples : samples of each period.

    Returns
    -------
    Samples and periods; `battery` stands for the bus: current into it and its voltage.
    """
    made = maps(boost(stage, source, bus_resistance_ohm), stage.switching_period_s, samples)
    z, memory = np.append(np.asarray(state, dtype=np.float64), 1.0), np.zeros(3)
    return follow(made, Gains(0.0, 0.0, 1.0, 1.0), stage.rectifier == "synchronous", np.zeros(periods), z, memory, duty)


def follow(
    made: Maps,
    control: Gains,
    synchronous: bool,
    reference: Array,
    state: Array,
    memory: Array,
    fixed_duty: float = -1.0,
) -> SwitchedRun:
    """Run the kernel over its maps; `state` and `memory` are changed to those of the end.

    Arguments
    ---------
    synchronous : the second switch carries current both ways.
    reference : mean inductor current asked for in each period, shape (n,) [A].
    state, memory : z, and what the control remembers: integral part, mean inductor current, mean terminal voltage.
    fixed_duty : duty of every period instead of the control's; below zero: the control.
    """
    points = np.empty((3, len(reference) * made.samples + 1))
    periods = np.empty((len(PERIOD_COLUMNS), len(reference)))
    run_periods(
        *(made.generators, made.steps, made.sums, made.outputs),
        *(made.tick_s, made.sample_s, made.samples),
        *control,
        synchronous,
        fixed_duty,
        reference,
        state,
        memory,
        points,
        periods,
    )
    return SwitchedRun(points, dict(zip(PERIOD_COLUMNS, periods, strict=True)))


def start(
    stage: SwitchedBuck, bus_voltage_v: float, load: BatteryLoad, current_a: float, pair_voltage_v: float
) -> tuple[Array, Array]:
    """Return state and control memory of a converter that has long carried a mean current.

    Arguments
    ---------
    current_a : mean current; a negative one is taken as none in the inductor [A].
    pair_voltage_v : voltage of the fast pair [V].
    """
    current = max(current_a, 0.0)
    terminal = load.voltage_v + pair_voltage_v + load.series_resistance_ohm * current
    duty = (terminal + stage.rectifier_voltage_v + stage.inductor_resistance_ohm * current) / (
        bus_voltage_v + stage.rectifier_voltage_v
    )
    ripple = (bus_voltage_v - terminal) * duty * stage.switching_period_s / stage.inductance_h if current > 0 else 0.0
    state = np.zeros(SIZE)
    state[INDUCTOR] = max(current - 0.5 * ripple, 0.0)
    state[CAPACITOR], state[THIRD], state[ONE] = terminal, pair_voltage_v, 1.0
    return state, np.array([duty - terminal / bus_voltage_v, current, terminal])
