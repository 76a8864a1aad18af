"""What the trials of the trackers come to, as named numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.quantity import Quantity
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.tracker.steady import steady
from pipeline.tracker.tracking_records import Tracking


def summary(
    source: Source, trackers: Mapping[str, AnyTracker], tracking: Tracking, ramps: Mapping[str, Any]
) -> list[Quantity]:
    """Return the numbers of every tracker in steady light and over all ramps.

    Arguments
    ---------
    ramps : the columns of TRACKING_RAMPS.
    """
    found: list[Quantity] = []
    for name, tracker in trackers.items():
        own = np.array(ramps["efficiency"])[np.array(ramps["tracker"]) == name]
        found += steady(source, name, tracker, tracking)
        found += [
            Quantity(f"{name}_ramps_efficiency", float(own.mean()), "1", "mean over the ramps of captured / available"),
            Quantity(f"{name}_worst_ramp", float(own.min()), "1", "the least of them"),
        ]
    return found
