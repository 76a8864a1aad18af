"""Supply: weather, panel, converters and load in; the power at the battery's terminals out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter

from pipeline.converter.efficiency import battery_power
from pipeline.converter.records import Load, PowerChain
from pipeline.files.content import without_digest
from pipeline.files.weather import told, weather_rows
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.panel import curves
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.weather.clear_sky import sky_of
from pipeline.weather.records import Weather


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Follow the panel's maximum power through the converters to the battery."""
    panel = Panel.model_validate(settings["panel"])
    weather: Weather = TypeAdapter(Weather).validate_python(without_digest(settings["weather"]))
    fitted = inputs.table("panel", "parameters")
    diode = SingleDiode(**{name: float(fitted[name][0]) for name in SingleDiode._fields})
    sky = sky_of(weather, 0.0, weather_rows(weather))  # how warm the air is has no say here
    points = curves.points(panel, diode, sky.irradiance_w_m2, sky.cell_temperature_c)
    supply = battery_power(
        sky.time_s,
        sky.irradiance_w_m2,
        sky.cell_temperature_c,
        points["max_power_w"],
        PowerChain.model_validate(settings["converter"]),
        Load.model_validate(settings["load"]),
        points["max_power_voltage_v"],
    )
    output.write("supply", supply)
    output.write("notes", {"note": list(told(weather))})
