"""The windows of a charge again, at the resolution of the converter's switches.

The charge gives the current asked for, the state of charge, and the voltage of everything slower than the battery's
fastest pair, which stands still for the few milliseconds of a window.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery, value_of
from pipeline.converter.records import SwitchedBuck
from pipeline.converter.switched import Edge, SwitchedRun, edges, run_buck
from pipeline.converter.topologies import BatteryLoad

Array = NDArray[np.float64]

_NO_PAIR = (1e-12, 1.0)
DEFAULT_DISCHARGE_OHM = 1e6


class View(NamedTuple):
    """A window at the resolution of the switches.

    Arguments
    ---------
    time_s, reference_a : start of each switching period and the current asked for in it, shape (n,).
    load : the battery as it was taken.
    run : what the converter did.
    edges : the steps and their answers.
    """

    time_s: Array
    reference_a: Array
    load: BatteryLoad
    run: SwitchedRun
    edges: list[Edge]

    @property
    def last_edges(self) -> list[Edge]:
        """Return the last step of each kind, in the order of the pulses."""
        return sorted({edge.kind: edge for edge in self.edges}.values())


def view(
    battery: Battery, stage: SwitchedBuck, bus_voltage_v: float, waveform: Mapping[str, Array], samples: int
) -> View | None:
    """Run the converter through one window of a charge.

    Arguments
    ---------
    waveform : rows of one window: `time_s`, `current_a`, `voltage_v`, `soc`.
    samples : samples of each switching period.

    Returns
    -------
    The window; none where it is shorter than two switching periods.
    """
    time, current, voltage = (np.asarray(waveform[name], dtype=float) for name in ("time_s", "current_a", "voltage_v"))
    period_s = stage.switching_period_s
    count = math.floor((time[-1] - time[0]) / period_s * (1.0 + 1e-12))
    if count < 2:
        return None
    starts = time[0] + period_s * np.arange(count)
    reference = _held(time, current, starts)
    load, pair_v = battery_load(battery, waveform)
    drawn = current < 0.0
    resistance = float(np.mean(voltage[drawn] / -current[drawn])) if drawn.any() else DEFAULT_DISCHARGE_OHM
    run = run_buck(stage, bus_voltage_v, load, reference, pair_v, samples, resistance)
    found = edges(reference, run.periods["battery_mean_a"], period_s, load.series_resistance_ohm)
    return View(starts, reference, load, run, found)


def battery_load(battery: Battery, waveform: Mapping[str, Array]) -> tuple[BatteryLoad, float]:
    """Return the battery as the converter sees it in a window, and the voltage of its fast pair at the start [V].

    Both the still voltage and that of the pair are those that reproduce the charge's terminal voltage best.

    Arguments
    ---------
    waveform : rows of one window: `time_s`, `current_a`, `voltage_v`, `soc`.
    """
    time, current, voltage = (np.asarray(waveform[name], dtype=float) for name in ("time_s", "current_a", "voltage_v"))
    soc, scale = float(np.mean(waveform["soc"])), battery.cells_in_series / battery.scale
    series = scale * value_of(battery.series_resistance_ohm, soc)
    fast = min(battery.pairs.values(), key=lambda pair: pair.time_constant_s, default=None)
    resistance, tau = _NO_PAIR if fast is None else (scale * value_of(fast.resistance_ohm, soc), fast.time_constant_s)
    driven = np.zeros_like(time)
    for row in range(1, len(time)):
        share = math.exp(-(time[row] - time[row - 1]) / tau)
        mean = 0.5 * (current[row] + current[row - 1])
        driven[row] = share * driven[row - 1] + (1.0 - share) * resistance * mean
    fades = np.exp(-(time - time[0]) / tau)
    rest = voltage - series * current - driven
    (still_v, pair_v), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(fades), fades]), rest, rcond=None)
    return BatteryLoad(float(still_v), series, resistance, tau), float(pair_v)


def _held(time: Array, current: Array, at: Array) -> Array:
    """Return the current at some times, straight between rows; at a step, the value after it."""
    right = np.clip(np.searchsorted(time, at, side="right"), 1, len(time) - 1)
    left = right - 1
    length = time[right] - time[left]
    share = np.divide(at - time[left], length, out=np.zeros_like(at), where=length > 0.0)
    return np.asarray(current[left] + share * (current[right] - current[left]))
