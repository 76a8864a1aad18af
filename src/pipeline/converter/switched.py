"""A converter switch by switch: exact from one switching instant to the next.

The boost converter runs at a duty that its tracker sets, the buck converter under its current control: in each period
the duty is the battery's voltage over the bus voltage, as the mean of the period before gave it, plus a proportional
and an integral part of the reference less the mean inductor current of that period. The integral stands still while the
duty is at a limit and between the pulses. A reference of zero turns the switch off: the second switch carries the
current as a diode until it is zero. A negative one does the same, and then lets a resistor discharge the battery (S4).
References change with the switching periods.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.records import BOOST, SwitchedBoost, SwitchedBuck
from pipeline.converter.steady import steady_state, trace
from pipeline.converter.switched_kernel import PERIOD_COLUMNS, run_periods
from pipeline.converter.topologies import (
    CAPACITOR,
    DIODE,
    INDUCTOR,
    LOW,
    ON,
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
from pipeline.quantity import Quantity

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


def of_boost(
    stage: SwitchedBoost, bus_voltage_v: float, panel_voltage_v: float, panel_current_a: float, samples: int
) -> list[Quantity]:
    """Return the boost converter's numbers with the panel at maximum power and the bus at its voltage.

    Arguments
    ---------
    bus_voltage_v : voltage of the bus [V].
    panel_voltage_v, panel_current_a : of all panels at maximum power [V], [A].
    samples : samples of a switching period.

    Returns
    -------
    The numbers; all NaN but the valley where the inductor current would not stay above zero behind a diode.
    """
    # At maximum power the tangent to the panel's curve has the resistance voltage over current.
    source = PanelSource(2.0 * panel_voltage_v, panel_voltage_v / panel_current_a)
    synchronous, period_s = stage.rectifier == "synchronous", stage.switching_period_s
    duty, resistance = operating_point(stage, bus_voltage_v, source)
    made = boost(stage, source, resistance)
    steady = steady_state(made, synchronous, duty, period_s)
    points = trace(made, synchronous, duty, period_s, samples, steady.state, 1)[:-1]
    off = LOW if synchronous else DIODE
    on = np.arange(samples) < duty * samples
    bus = np.where(on, points @ made.outputs[ON, 1], points @ made.outputs[off, 1])
    swing = points[:, THIRD] - panel_voltage_v
    continuous = synchronous or steady.valley_a >= 0.0
    found = {
        "boost_duty": duty,
        "boost_inductor_ripple_a": _peak_to_peak(points[:, INDUCTOR]),
        "boost_bus_ripple_v": _peak_to_peak(bus),
        "boost_panel_ripple_v": _peak_to_peak(points[:, THIRD]),
        "boost_missed_w": float(np.mean(swing**2)) / source.resistance_ohm,
        "boost_conduction_efficiency": bus_voltage_v**2 / resistance / (panel_voltage_v * panel_current_a),
    }
    numbers = [BOOST.quantity(name, value if continuous else math.nan) for name, value in found.items()]
    return [*numbers, BOOST.quantity("boost_valley_a", steady.valley_a)]


def operating_point(stage: SwitchedBoost, bus_voltage_v: float, source: PanelSource) -> tuple[float, float]:
    """Return duty, and resistance of what the bus feeds [ohm], with the panel and the bus at their mean voltages.

    Arguments
    ---------
    bus_voltage_v : mean voltage of the bus [V].
    source : the panel's tangent at maximum power; its voltage there is half of that without current.
    """
    from scipy.optimize import root

    panel_v = 0.5 * source.voltage_v
    power_w = panel_v**2 / source.resistance_ohm
    synchronous = stage.rectifier == "synchronous"

    def misses(unknowns: NDArray[np.float64]) -> list[float]:
        made = boost(stage, source, math.exp(float(unknowns[1])))
        duty = min(max(float(unknowns[0]), 1e-3), 1.0 - 1e-3)
        mean = steady_state(made, synchronous, duty, stage.switching_period_s).mean
        # In a periodic state a capacitor's mean voltage is that of its node.
        return [float(mean[THIRD]) / panel_v - 1.0, float(mean[CAPACITOR]) / bus_voltage_v - 1.0]

    solution = root(misses, [1.0 - panel_v / bus_voltage_v, math.log(bus_voltage_v**2 / power_w)], tol=1e-13)
    return float(solution.x[0]), math.exp(float(solution.x[1]))


def _peak_to_peak(values: NDArray[np.float64]) -> float:
    return float(np.max(values) - np.min(values))


SETTLED = 0.02
"""Share of the step within which a current counts as settled."""
KINDS = {
    (0, 1): "charge begins",
    (1, 0): "charge ends",
    (1, -1): "discharge begins",
    (-1, 0): "discharge ends",
    (-1, 1): "charge begins",
    (0, -1): "discharge begins",
}


class Edge(NamedTuple):
    """A step of the reference and the answer of the current, switching ripple taken out.

    Arguments
    ---------
    period : number of the switching period at whose start the reference steps.
    kind : what begins or ends.
    before_a, after_a : reference on both sides [A].
    overshoot_a : farthest that the current goes past the new reference, in the direction of the step [A].
    settling_s : time until it stays within `SETTLED` of the step; the whole stretch where it does not [s].
    ringing_j : heat in the series resistance from what the current is off the reference once it has reached it [J].
    deviation_j : the same from the step on: also of the rise or fall itself [J].
    """

    period: int
    kind: str
    before_a: float
    after_a: float
    overshoot_a: float
    settling_s: float
    ringing_j: float
    deviation_j: float


def edges(reference_a: Array, current_a: Array, period_s: float, resistance_ohm: float) -> list[Edge]:
    """Return every step from charging, resting or discharging to another of these that has its whole answer.

    Arguments
    ---------
    reference_a, current_a : reference and mean current of each switching period, shape (n,) [A].
    period_s : length of a switching period [s].
    resistance_ohm : series resistance that the current heats [ohm].

    Returns
    -------
    One for each step but the last, whose answer the end of the run cuts off.
    """
    states = np.sign(np.where(np.abs(reference_a) < 1e-9, 0.0, reference_a)).astype(int)
    places = np.flatnonzero(np.diff(states)) + 1
    return [
        _edge(reference_a, current_a, int(first), int(last), period_s, resistance_ohm, states)
        for first, last in pairwise(places)
    ]


def _edge(
    reference: Array,
    current: Array,
    first: int,
    last: int,
    period_s: float,
    resistance: float,
    states: NDArray[np.int_],
) -> Edge:
    before, after = float(reference[first - 1]), float(reference[first])
    off = current[first:last] - reference[first:last]
    past = off if after > before else -off
    reached = np.flatnonzero(past >= 0.0)
    begin = int(reached[0]) if len(reached) else len(past)
    outside = np.flatnonzero(np.abs(off) > SETTLED * abs(after - before))
    return Edge(
        first,
        KINDS[int(states[first - 1]), int(states[first])],
        before,
        after,
        float(max(past.max(), 0.0)),
        period_s * (int(outside[-1]) + 1 if len(outside) else 0),
        resistance * period_s * float(np.sum(off[begin:] ** 2)),
        resistance * period_s * float(np.sum(off**2)),
    )
