"""What the trials of the trackers come to, as named numbers: in steady light, and over all ramps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.tracking.records import TRACKING_NUMBERS, Tracking
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2
from pipeline.quantity import Quantity
from pipeline.tracker.loop import available, course
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source

Array = NDArray[np.float64]

NEAR_OPEN_CIRCUIT = 0.95
"""Share of V_oc from which the settling time at the start is taken."""


def summary(
    source: Source, trackers: Mapping[str, AnyTracker], tracking: Tracking, ramps: Mapping[str, Any]
) -> list[Quantity]:
    """Return the numbers of every tracker in steady light and over all ramps.

    Arguments
    ---------
    source : panels and converter.
    trackers, tracking : the trackers by name, and how they are tried.
    ramps : the columns of the table of ramps.
    """
    found: list[Quantity] = []
    for name, tracker in trackers.items():
        own = np.array(ramps["efficiency"])[np.array(ramps["tracker"]) == name]
        found += steady(source, name, tracker, tracking)
        found += [
            TRACKING_NUMBERS.quantity("{tracker}_ramps_efficiency", own.mean(), tracker=name),
            TRACKING_NUMBERS.quantity("{tracker}_worst_ramp", own.min(), tracker=name),
        ]
    return found


def steady(source: Source, name: str, tracker: AnyTracker, tracking: Tracking) -> list[Quantity]:
    """Return a tracker's efficiency and ripple at 1000 W/m2, and its settling times from start and after a step.

    Arguments
    ---------
    source : panels and converter.
    name : the first word of each number's name.
    tracker, tracking : the tracker, and how it is tried.
    """
    row_s, cells = tracker.perturbation_period_s, tracking.cell_temperature_c
    time = np.arange(0.0, tracking.steady_s, row_s)
    full = np.full(time.shape, REFERENCE_IRRADIANCE_W_M2)
    most = float(available(source, REFERENCE_IRRADIANCE_W_M2, cells)[0])
    afar = tracker.model_copy(update={"start_voltage_share": NEAR_OPEN_CIRCUIT})
    made = course(source, afar, time, full, cells)
    power, last = made.energy_j / row_s, slice(-(len(time) // 3), None)
    before = np.arange(-tracking.steady_s, 0.0, row_s)
    stepped = course(
        source,
        tracker,
        np.concatenate([before, time]),
        np.concatenate([np.full(before.shape, tracking.start_w_m2), full]),
        cells,
    )
    after = stepped.energy_j[len(before) :] / row_s
    found = {
        "{tracker}_steady_efficiency": float(power[last].mean()) / most,
        "{tracker}_ripple_v": float(np.ptp(made.voltage_v[last])),
        "{tracker}_ripple_w": float(np.ptp(power[last])),
        "{tracker}_start_s": settling(power, row_s, tracking.settled_share),
        "{tracker}_step_s": settling(after, row_s, tracking.settled_share),
    }
    return [TRACKING_NUMBERS.quantity(pattern, value, tracker=name) for pattern, value in found.items()]


def settling(power: Array, row_s: float, band: float) -> float:
    """Return the time until the power stays within a band about its mean in the last third [s].

    Arguments
    ---------
    power : mean of each row [W], shape (n,).
    row_s : length of a row [s].
    band : half the width of the band over that mean [1].
    """
    final = float(power[-(len(power) // 3) :].mean())
    outside = np.flatnonzero(np.abs(power - final) > band * final)
    return row_s * float(outside[-1] + 1) if outside.size else 0.0
