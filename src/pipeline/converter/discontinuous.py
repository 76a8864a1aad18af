"""A boost converter whose inductor current ends within the period: its periodic state at a mean input and output."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.records import SwitchedBoost
from pipeline.converter.topologies import (
    BLOCKED,
    CAPACITOR,
    DIODE,
    INDUCTOR,
    ON,
    ONE,
    SIZE,
    THIRD,
    PanelSource,
    Topologies,
    boost,
    exponential,
)

Array = NDArray[np.float64]


class Discontinuous(NamedTuple):
    """A periodic state without current at its start, and its means; the diode's current ends at `end_a`."""

    state: Array
    mean: Array
    end_a: float


def discontinuous_state(topologies: Topologies, on_s: float, diode_s: float, period_s: float) -> Discontinuous:
    """Return the periodic state in which the switch conducts, then the diode, then neither.

    Arguments
    ---------
    topologies : the converter's circuits.
    on_s, diode_s, period_s : lengths of switch, diode and period [s]; right where the diode's current ends at zero.
    """
    lengths = ((ON, on_s), (DIODE, diode_s), (BLOCKED, period_s - on_s - diode_s))
    made = [exponential(topologies.generators[place], length) for place, length in lengths]
    whole = made[2][0] @ made[1][0] @ made[0][0]
    state = np.ones(SIZE)
    state[INDUCTOR] = 0.0
    slow = [CAPACITOR, THIRD]
    state[slow] = np.linalg.solve(np.eye(len(slow)) - whole[np.ix_(slow, slow)], whole[slow, ONE])
    here, passed = state, np.zeros(SIZE)
    ends = []
    for step, integral in made:
        passed = passed + integral @ here
        here = step @ here
        ends.append(float(here[INDUCTOR]))
    return Discontinuous(state, passed / period_s, ends[1])


def discontinuous_point(
    stage: SwitchedBoost, bus_voltage_v: float, source: PanelSource
) -> tuple[float, float, Discontinuous]:
    """Return duty, resistance of what the bus feeds [ohm], and the state, panel and bus at their mean voltages.

    Arguments
    ---------
    stage : the converter, whose second switch is a diode.
    bus_voltage_v : mean voltage of the bus [V].
    source : the panel's tangent at maximum power; its voltage there is half of that without current.

    Raises
    ------
    ArithmeticError : no such state; the current is continuous.
    """
    from scipy.optimize import root

    panel_v, period_s = 0.5 * source.voltage_v, stage.switching_period_s
    power_w = panel_v**2 / source.resistance_ohm
    step_v = bus_voltage_v - panel_v
    # Of the ideal converter: volt-seconds of the inductor, and half the peak times the time for the mean current.
    duty = math.sqrt(2.0 * stage.inductance_h * power_w * step_v / (panel_v**2 * period_s * bus_voltage_v))
    peak_a = panel_v * duty * period_s / stage.inductance_h

    def at(unknowns: NDArray[np.float64]) -> Discontinuous:
        share, diode, resistance = (math.exp(float(value)) for value in unknowns)
        made = boost(stage, source, resistance)
        return discontinuous_state(made, share * period_s, diode * period_s, period_s)

    def misses(unknowns: NDArray[np.float64]) -> list[float]:
        found = at(unknowns)
        return [
            found.end_a / peak_a,
            float(found.mean[THIRD]) / panel_v - 1.0,
            float(found.mean[CAPACITOR]) / bus_voltage_v - 1.0,
        ]

    start = [math.log(duty), math.log(duty * panel_v / step_v), math.log(bus_voltage_v**2 / power_w)]
    solution = root(misses, start, tol=1e-13)
    share, diode, resistance = (math.exp(float(value)) for value in solution.x)
    if max(map(abs, misses(solution.x))) > 1e-9 or share + diode > 1.0:
        raise ArithmeticError(
            f"no discontinuous state at {power_w:g} W: switch {share:g} and diode {diode:g} of a period"
        )
    return share, resistance, at(solution.x)
