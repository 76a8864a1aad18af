"""A converter at a fixed duty, in continuous and discontinuous conduction: periodic state, ripple, traces."""

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
    LOW,
    ON,
    ONE,
    SIZE,
    THIRD,
    PanelSource,
    Topologies,
    boost,
    exponential,
)
from pipeline.jit import kernel

Array = NDArray[np.float64]


def from_start(maps: Array) -> Array:
    """Return the transposed maps from the start of a period to each of its samples, shape (samples, 4, 4).

    Samples then wait for the period's start alone, not for one another.

    Arguments
    ---------
    maps : those from each sample to the next, shape (samples, 4, 4).
    """
    found, whole = np.empty_like(maps), np.eye(SIZE)
    for sample, one in enumerate(maps):
        whole = one @ whole
        found[sample] = whole.T
    return found


@kernel
def trace_samples(maps: Array, state: Array, points: Array) -> None:
    """Fill in z at every sample.

    Arguments
    ---------
    maps : as `from_start` returns them, shape (samples, 4, 4).
    state : z at the start, shape (4,).
    points : z at each sample and at the end, shape (periods samples + 1, 4).
    """
    samples, last = maps.shape[0], points.shape[0] - 1
    a, b, c, d = state[0], state[1], state[2], state[3]
    points[0, 0], points[0, 1], points[0, 2], points[0, 3] = a, b, c, d
    for begin in range(0, last, samples):
        for sample in range(min(samples, last - begin)):
            m, point = maps[sample], points[begin + sample + 1]
            for row in range(SIZE):
                point[row] = (m[0, row] * a + m[1, row] * b) + (m[2, row] * c + m[3, row] * d)
        end = points[min(begin + samples, last)]
        a, b, c, d = end[0], end[1], end[2], end[3]


class Steady(NamedTuple):
    """A periodic state: z at the start of a period, the means of z over it, and what it needs to be true.

    `valley_a` is the least inductor current; below zero a converter whose second switch is a diode does otherwise.
    """

    state: Array
    mean: Array
    valley_a: float


def steady_state(topologies: Topologies, synchronous: bool, duty: float, period_s: float) -> Steady:
    """Return the periodic state at a fixed duty, from the fixed point of the affine map of a period.

    Arguments
    ---------
    topologies : the converter's circuits.
    synchronous : which circuit follows the switch.
    duty : share of the period for which the switch is on [1].
    period_s : length of a switching period [s].
    """
    off = LOW if synchronous else DIODE
    on_map, on_sum = exponential(topologies.generators[ON], duty * period_s)
    off_map, off_sum = exponential(topologies.generators[off], (1.0 - duty) * period_s)
    whole = off_map @ on_map
    state = np.ones(SIZE)
    state[:ONE] = np.linalg.solve(np.eye(ONE) - whole[:ONE, :ONE], whole[:ONE, ONE])
    mean = (on_sum @ state + off_sum @ on_map @ state) / period_s
    return Steady(state, mean, float(min(state[INDUCTOR], (on_map @ state)[INDUCTOR])))


def sample_maps(
    topologies: Topologies, synchronous: bool, duty: float, period_s: float, samples: int
) -> tuple[Array, NDArray[np.int64]]:
    """Return the map from each sample of a period to the next, shape (samples, 4, 4), and its circuits, (samples,)."""
    off = LOW if synchronous else DIODE
    length, on_s = period_s / samples, duty * period_s
    whole = {place: exponential(topologies.generators[place], length)[0] for place in (ON, off)}
    found, places = np.empty((samples, SIZE, SIZE)), np.empty(samples, dtype=np.int64)
    for sample in range(samples):
        on = min(max(on_s - sample * length, 0.0), length)
        places[sample] = ON if on > 0.0 else off
        if 0.0 < on < length:
            first = exponential(topologies.generators[ON], on)[0]
            found[sample] = exponential(topologies.generators[off], length - on)[0] @ first
        else:
            found[sample] = whole[places[sample]]
    return found, places


def trace(
    topologies: Topologies, synchronous: bool, duty: float, period_s: float, samples: int, state: Array, periods: int
) -> Array:
    """Return z at every sample of some periods at a fixed duty, shape (periods samples + 1, 4).

    Arguments
    ---------
    state : z at the start, shape (4,).
    """
    made, _ = sample_maps(topologies, synchronous, duty, period_s, samples)
    points = np.empty((periods * samples + 1, SIZE))
    trace_samples(from_start(made), np.asarray(state, dtype=np.float64), points)
    return points


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
