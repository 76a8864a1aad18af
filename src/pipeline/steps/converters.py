"""Converters: their parts and losses in; efficiency over load, and the averaged model against the switches, out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import quantity, schemas_supply, tables
from pipeline.converter.efficiency_map import against_switches, efficiency_map, quantities
from pipeline.converter.records import PowerChain


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Look at both converters at every load up to the panel's maximum power."""
    chain = PowerChain.model_validate(settings["converter"])
    voltage, power = float(settings["panel_voltage_v"]), float(settings["panel_power_w"])
    found, check = efficiency_map(chain, voltage, power), against_switches(chain, voltage, power)
    columns = {"efficiency": found, "check": check, "quantities": quantity.columns(quantities(found, check))}
    for name, own in columns.items():
        file, table = schemas_supply.ARTEFACTS["converters", name]
        tables.write(table, own, output / file)
