"""Trackers in steady light: efficiency, ripple, and how long they take to settle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2
from pipeline.quantity import Quantity
from pipeline.tracker.capture import available, course
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.tracker.tracking_records import Tracking

Array = NDArray[np.float64]

NEAR_OPEN_CIRCUIT = 0.95
"""Share of V_oc from which the settling time at the start is taken."""


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
    found: list[tuple[str, float, str, str]] = [
        ("steady_efficiency", float(power[last].mean()) / most, "1", "captured at 1000 W/m2, settled"),
        ("ripple_v", float(np.ptp(made.voltage_v[last])), "V", "swing of the panel's voltage there"),
        ("ripple_w", float(np.ptp(power[last])), "W", "swing of the power of its periods there"),
        ("start_s", settling(power, row_s, tracking.settled_share), "s", "settling time from near open circuit"),
        ("step_s", settling(after, row_s, tracking.settled_share), "s", "settling time after a step"),
    ]
    return [Quantity(f"{name}_{key}", value, unit, words) for key, value, unit, words in found]


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
