"""Daylight: a day's weather, the panel, a tracker, the converters and a load in; what the battery could have out."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter

from pipeline.bus.load import drawn
from pipeline.bus.records import LoadProfile
from pipeline.converter.records import PowerChain, SwitchedBoost
from pipeline.day.sunlight import Tracking, by_share, in_closed_loop, sunlight
from pipeline.files.content import without_digest
from pipeline.files.load import load_rows, told
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source
from pipeline.weather.clear_sky import Sky


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Follow the light through panel, tracker, boost converter, bus and load to the battery's terminals."""
    rows = inputs.table(inputs.of_kind("weather")[0], "weather")
    chain = PowerChain.model_validate(settings["converter"])
    panel = Panel.model_validate(settings["panel"])
    fitted = inputs.table("panel", "parameters")
    diode = SingleDiode(**{name: float(fitted[name][0]) for name in SingleDiode._fields})
    clock_s, end_s = float(rows["clock_s"][0]), float(rows["time_s"][-1] + rows["interval_s"][-1])
    sky = Sky(rows["time_s"], rows["irradiance_w_m2"], rows["ambient_c"], rows["cell_temperature_c"], clock_s, end_s)
    profile: LoadProfile = TypeAdapter(LoadProfile).validate_python(without_digest(settings["load"]))
    date = None if settings["date"] is None else datetime.date.fromisoformat(settings["date"])
    load = drawn(profile, clock_s, clock_s + end_s, load_rows(profile, date))
    found = sunlight(sky, load, panel, diode, _tracking(settings, panel, diode, chain), chain)
    columns = {name: column for name, column in found._asdict().items() if name != "could"}
    columns |= found.could._asdict() | {"clock_s": found.time_s + clock_s}
    output.write("daylight", columns)
    output.write("notes", {"note": list(told(profile, date))})


def _tracking(settings: Mapping[str, Any], panel: Panel, diode: SingleDiode, chain: PowerChain) -> Tracking:
    """Return the tracker in closed loop; the chain's share where no tracker or no converter's parts are given."""
    if settings["tracker"] is None or settings["boost"] is None:
        return by_share(chain.tracker_efficiency)
    boost = SwitchedBoost.model_validate(settings["boost"])
    tracker: AnyTracker = TypeAdapter(AnyTracker).validate_python(settings["tracker"])
    return in_closed_loop(Source(panel, diode, boost, chain.bus_voltage_v), tracker)
