"""Day: a day's weather, the panel, the bus and a mode in; the battery's day, its switchings and its stages out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from pipeline import own_series, quantity, schemas, schemas_day, tables
from pipeline.bus.load import drawn
from pipeline.bus.records import LoadProfile
from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.converter.records import PowerChain
from pipeline.day import columns, summary
from pipeline.day.charge import Surroundings, charge_over_day
from pipeline.day.records import DayConditions
from pipeline.day.sunlight import Sunlight, sunlight
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C, Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.weather.sky import Sky


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Charge the battery over the day and write what came of it."""
    chain = PowerChain.model_validate(settings["converter"])
    weather = next(folder for name, folder in inputs.items() if name.startswith("weather/"))
    light, clock_s = _light(settings, weather, inputs["panel"], chain)
    charge = charge_over_day(
        Battery.model_validate(settings["battery"]),
        Mode.model_validate(settings["mode"]),
        Surroundings(light.time_s, light.could.battery_w, light.ambient_c, light.end_s),
        DayConditions.model_validate(settings["conditions"]),
        EngineSettings.model_validate(settings["engine"]),
    )
    found = columns.trace(charge, light, chain, clock_s)
    parts = columns.stages(found, charge)
    stages = {name: [getattr(part, name) for part in parts] for name in columns.Stage._fields}
    numbers = summary.quantities(charge, found, parts)
    tables.write(schemas_day.DAY_TRACE, found, output / "trace.parquet")
    tables.write(schemas_day.DAY_SWITCHING, columns.switching(charge, clock_s), output / "switching.parquet")
    tables.write(schemas_day.DAY_STAGES, stages, output / "stages.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _light(settings: Mapping[str, Any], weather: Path, panel_folder: Path, chain: PowerChain) -> tuple[Sunlight, float]:
    """Return the day without its battery, and the local time at which it begins [s]."""
    rows = tables.read(schemas_day.WEATHER, weather / "weather.parquet")
    numbers = tables.read(schemas.QUANTITIES, weather / "quantities.parquet")
    end_s = float(numbers["value"][numbers["quantity"] == "length_s"][0])
    clock_s = float(rows["clock_s"][0])
    sky = Sky(rows["time_s"], rows["irradiance_w_m2"], rows["ambient_c"], rows["cell_temperature_c"], clock_s, end_s)
    profile: LoadProfile = TypeAdapter(LoadProfile).validate_python(own_series.without_digest(settings["load"]))
    load = drawn(profile, clock_s, clock_s + end_s, own_series.load_rows(profile))
    panel = Panel.model_validate(settings["panel"])
    fitted = tables.read(schemas.PANEL_PARAMETERS, panel_folder / "parameters.parquet")
    diode = SingleDiode(**{name: float(fitted[name][0]) for name in SingleDiode._fields})
    count = panel.panels_in_series * panel.panels_in_parallel

    def power(irradiance: Any, cells: Any) -> Any:
        return count * maximum_power(panel, diode, irradiance, cells).max_power_w

    standard = power(np.array([REFERENCE_IRRADIANCE_W_M2]), np.array([REFERENCE_TEMPERATURE_C]))
    return sunlight(sky, load, power, float(standard[0]), chain, end_s), clock_s
