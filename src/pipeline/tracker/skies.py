"""Trackers over days: a bell of irradiance, under clouds that come and go at random."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.tracker.capture import available, capture
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.tracker.tracking_records import Sky

Array = NDArray[np.float64]

JOULES_PER_WATT_HOUR = 3600.0


def irradiance(sky: Sky, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return times from sunrise [s] and irradiance [W/m2], shape (n,) each.

    Times in and out of clouds are exponentially distributed, as in a two-state Markov process.
    """
    time = np.arange(0.0, sky.daylight_s, sky.sample_s)
    middle = time + 0.5 * sky.sample_s
    bell = sky.peak_w_m2 * np.sin(np.pi * np.minimum(middle / sky.daylight_s, 1.0)) ** sky.bell_exponent
    if sky.mean_cloud_s == 0.0:
        return time, bell
    count = int(3.0 * sky.daylight_s / (sky.mean_clear_s + sky.mean_cloud_s)) + 10
    spans = np.column_stack([rng.exponential(sky.mean_clear_s, count), rng.exponential(sky.mean_cloud_s, count)])
    changes = np.cumsum(spans.ravel())
    corners = np.ravel(np.column_stack([changes, changes + sky.edge_s]))
    levels = np.ravel([[1.0, sky.cloud_transmission, sky.cloud_transmission, 1.0]] * count)
    order = np.argsort(corners, kind="stable")
    return time, bell * np.interp(middle, corners[order], levels[order])


def captured(
    source: Source, trackers: Mapping[str, AnyTracker], skies: Mapping[str, Sky], seed: int
) -> dict[str, list[Any]]:
    """Return what each tracker captures of each day: the columns of TRACKING_DAY."""
    rows = []
    for place, (sky_name, sky) in enumerate(skies.items()):
        time, light = irradiance(sky, np.random.default_rng(np.random.SeedSequence([seed, place])))
        cells = sky.ambient_c + sky.sun_rise_k * light / 1000.0
        hours = sky.sample_s / JOULES_PER_WATT_HOUR
        there = float(available(source, light, cells).sum()) * hours
        for name, tracker in trackers.items():
            got = float(capture(source, tracker, time, light, cells).sum()) * hours
            rows.append((name, sky_name, there, got, got / there))
    columns = ("tracker", "sky", "available_wh", "captured_wh", "efficiency")
    return {column: [row[number] for row in rows] for number, column in enumerate(columns)}
