"""Day: a day's weather, the panel, the bus and a mode in; the battery's day, its switchings and its stages out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import quantity, schemas, schemas_day, tables
from pipeline.bus.flows import Available, kept_by_bus_j
from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.converter.records import PowerChain
from pipeline.day import columns, summary
from pipeline.day.charge import Surroundings, charge_over_day
from pipeline.day.records import DayConditions
from pipeline.day.sunlight import Sunlight


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Charge the battery over the day and write what came of it."""
    chain = PowerChain.model_validate(settings["converter"])
    rows = tables.read(schemas_day.DAYLIGHT, _daylight(inputs) / "daylight.parquet")
    light = Sunlight(
        **{name: rows[name] for name in Sunlight._fields if name != "could"},
        could=Available(*(rows[name] for name in Available._fields)),
    )
    end_s = float(light.time_s[-1] + light.interval_s[-1])
    conditions = DayConditions.model_validate(settings["conditions"])
    kept_j = kept_by_bus_j(float(settings["bus_capacitance_f"]), conditions.bus_swing_share, light.could, chain)
    charge = charge_over_day(
        Battery.model_validate(settings["battery"]),
        Mode.model_validate(settings["mode"]),
        Surroundings(light.time_s, light.could.battery_w, light.ambient_c, end_s, kept_j),
        conditions,
        EngineSettings.model_validate(settings["engine"]),
    )
    clock_s = float(rows["clock_s"][0])
    found = columns.trace(charge, light, chain, clock_s)
    parts = columns.stages(found, charge)
    stages = {name: [getattr(part, name) for part in parts] for name in columns.Stage._fields}
    numbers = summary.quantities(charge, found, parts)
    tables.write(schemas_day.DAY_TRACE, found, output / "trace.parquet")
    tables.write(schemas_day.DAY_SWITCHING, columns.switching(charge, clock_s), output / "switching.parquet")
    tables.write(schemas_day.DAY_STAGES, stages, output / "stages.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _daylight(inputs: Mapping[str, Path]) -> Path:
    return next(folder for name, folder in inputs.items() if name.startswith("daylight/"))
