"""What the boost converter does with the panel at maximum power: duty, ripple, losses by conduction."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.records import BOOST, SwitchedBoost
from pipeline.converter.steady import steady_state, trace
from pipeline.converter.topologies import CAPACITOR, DIODE, INDUCTOR, LOW, ON, THIRD, PanelSource, boost
from pipeline.quantity import Quantity


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
