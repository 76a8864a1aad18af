"""Day: a day's weather, the panel, the bus and a mode in; the battery's day, its switchings and its stages out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.bus.flows import Available, kept_by_bus_j
from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.converter.records import PowerChain
from pipeline.day.charge import Surroundings, charge_over_day
from pipeline.day.records import DayConditions
from pipeline.day.sunlight import Sunlight
from pipeline.experiments.days import summary
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge the battery over the day and write what came of it."""
    chain = PowerChain.model_validate(settings["converter"])
    rows = inputs.table(inputs.of_kind("daylight")[0], "daylight")
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
    found = summary.trace(charge, light, chain, clock_s)
    parts = summary.stages(found, charge)
    output.write("trace", found)
    output.write("switching", summary.switching(charge, clock_s))
    output.rows("stages", parts, summary.Stage._fields)
    output.write("missed", {"missed": [charge.missed] if charge.missed else []})
    output.numbers(summary.quantities(charge, found, parts))
