"""Trackers over days at a place, clear or with clouds: those of the weather's room, at the resolution of a tracker."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.tracker.capture import available, capture
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.weather.clear_sky import day
from pipeline.weather.records import ClearSky

JOULES_PER_WATT_HOUR = 3600.0


def captured(source: Source, trackers: Mapping[str, AnyTracker], skies: Mapping[str, ClearSky]) -> dict[str, list[Any]]:
    """Return what each tracker captures of each day from first to last light: the columns of TRACKING_DAY."""
    rows = []
    for sky_name, weather in skies.items():
        sky = day(weather)
        light, cells = sky.irradiance_w_m2, sky.cell_temperature_c
        hours = weather.interval_s / JOULES_PER_WATT_HOUR
        there = float(available(source, light, cells).sum()) * hours
        for name, tracker in trackers.items():
            got = float(capture(source, tracker, sky.time_s, light, cells).sum()) * hours
            rows.append((name, sky_name, there, got, got / there))
    columns = ("tracker", "sky", "available_wh", "captured_wh", "efficiency")
    return {column: [row[number] for row in rows] for number, column in enumerate(columns)}
