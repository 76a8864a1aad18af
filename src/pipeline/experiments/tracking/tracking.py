"""Tracking: panel, boost converter and trackers in; what each captures of ramps, days and shadows out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from pipeline.converter.records import SwitchedBoost
from pipeline.experiments.tracking import shading
from pipeline.experiments.tracking.records import Ramps, Tracking
from pipeline.experiments.tracking.shading import summary
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker.loop import available, capture, course
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.weather.clear_sky import day
from pipeline.weather.records import ClearSky

Array = NDArray[np.float64]

ROW_S = 0.05
"""Length of the intervals over which the irradiance of a ramp is taken as constant."""
SETTLING_S = 60.0
"""Time at the foot before a ramp, which is not counted."""
JOULES_PER_WATT_HOUR = 3600.0


def profile(ramps: Ramps, slope: float, repetitions: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return times [s], irradiance [W/m2] and whether a row counts, shape (n,) each; time 0 is where it counts from."""
    rise_s = (ramps.high_w_m2 - ramps.low_w_m2) / slope
    corners = np.cumsum([0.0, *([rise_s, ramps.dwell_s, rise_s, ramps.dwell_s] * repetitions)])
    levels = [ramps.low_w_m2, *([ramps.high_w_m2, ramps.high_w_m2, ramps.low_w_m2, ramps.low_w_m2] * repetitions)]
    time = np.arange(-SETTLING_S, float(corners[-1]) - 0.5 * ROW_S, ROW_S)
    irradiance: Array = np.interp(time + 0.5 * ROW_S, corners, levels)
    return time, irradiance, np.asarray(time > -0.5 * ROW_S)


def efficiencies(source: Source, trackers: Mapping[str, AnyTracker], tracking: Tracking) -> dict[str, list[Any]]:
    """Return what each tracker captures of each ramp: the columns of the table of ramps."""
    rows = [row for name, tracker in trackers.items() for row in _of_tracker(source, name, tracker, tracking)]
    return {key: [row[key] for row in rows] for key in rows[0]}


def _of_tracker(source: Source, name: str, tracker: AnyTracker, tracking: Tracking) -> Iterator[dict[str, Any]]:
    for group, ramps in tracking.ramps.items():
        for slope, repetitions in zip(ramps.slopes_w_m2_s, ramps.repetitions, strict=True):
            time, irradiance, counts = profile(ramps, slope, repetitions)
            energy = course(source, tracker, time, irradiance, tracking.cell_temperature_c).energy_j
            most = ROW_S * available(source, irradiance, tracking.cell_temperature_c)
            captured, there = float(energy[counts].sum()), float(most[counts].sum())
            yield {
                "tracker": name,
                "group": group,
                "low_w_m2": ramps.low_w_m2,
                "high_w_m2": ramps.high_w_m2,
                "slope_w_m2_s": slope,
                "repetitions": repetitions,
                "available_j": there,
                "captured_j": captured,
                "efficiency": captured / there,
            }


def shown_course(source: Source, trackers: Mapping[str, AnyTracker], tracking: Tracking) -> dict[str, Any]:
    """Return the course of one ramp, up and down once, under each tracker: the columns of the table of its course."""
    slope = tracking.shown_slope_w_m2_s
    ramps = [ramps for ramps in tracking.ramps.values() if slope in ramps.slopes_w_m2_s][-1]
    time, irradiance, _ = profile(ramps, slope, 1)
    wanted = time > -0.2 * ramps.dwell_s
    most = available(source, irradiance, tracking.cell_temperature_c)
    found: dict[str, list[Any]] = {}
    for name, tracker in trackers.items():
        made = course(source, tracker, time, irradiance, tracking.cell_temperature_c)
        columns = {
            "tracker": np.full(time.shape, name, dtype=object),
            "time_s": time + ROW_S,
            "irradiance_w_m2": irradiance,
            "voltage_v": made.voltage_v,
            "power_w": made.energy_j / ROW_S,
            "available_w": most,
            "duty": made.duty,
        }
        for key, column in columns.items():
            found.setdefault(key, []).append(column[wanted])
    return {key: np.concatenate(parts) for key, parts in found.items()}


def captured(source: Source, trackers: Mapping[str, AnyTracker], skies: Mapping[str, ClearSky]) -> dict[str, list[Any]]:
    """Return what each tracker captures of each day from first to last light: the columns of the table of days."""
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


_TRACKERS: TypeAdapter[dict[str, AnyTracker]] = TypeAdapter(dict[str, AnyTracker])


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Try every tracker on everything that is configured."""
    fitted = inputs.table("panel", "parameters")
    source = Source(
        Panel.model_validate(settings["panel"]),
        SingleDiode(**{name: float(fitted[name][0]) for name in SingleDiode._fields}),
        SwitchedBoost.model_validate(settings["boost"]),
        float(settings["bus_voltage_v"]),
    )
    trackers = _TRACKERS.validate_python(settings["trackers"])
    tracking = Tracking.model_validate(settings["tracking"])
    ramps = efficiencies(source, trackers, tracking)
    output.write("ramps", ramps)
    output.write("course", shown_course(source, trackers, tracking))
    output.write("day", captured(source, trackers, tracking.skies))
    curves, ends = shading.ends(source, trackers, tracking.shading, tracking.cell_temperature_c)
    output.write("shading_curves", curves)
    output.write("shading_ends", ends)
    output.numbers(summary(source, trackers, tracking, ramps))
