"""Charge: one battery, one mode, one supply in; the trace, the enlarged windows, the summary and the energies out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import schemas, tables
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, simulate


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Charge the battery and write what came of it."""
    charge = simulate(
        Battery.model_validate(settings["battery"]),
        Mode.model_validate(settings["mode"]),
        _supply(inputs),
        ChargeSettings.model_validate(settings["charge"]),
        EngineSettings.model_validate(settings["engine"]),
    )
    fields = ("quantity", "value", "text", "unit", "description")
    summary = {name: [getattr(quantity, name) for quantity in charge.summary] for name in fields}
    tables.write(schemas.CHARGE_TRACE, charge.trace, output / "trace.bdf.parquet")
    tables.write(schemas.CHARGE_WAVEFORM, charge.waveform, output / "waveform.parquet")
    tables.write(schemas.CHARGE_SUMMARY, summary, output / "summary.parquet")
    tables.write(schemas.CHARGE_PHASES, charge.phases, output / "phases.parquet")
    tables.write(schemas.CHARGE_ENERGY, charge.energy, output / "energy.parquet")


def _supply(inputs: Mapping[str, Path]) -> Supply:
    """Return the power at the battery's terminals; without a supply step, a bench supply that gives any."""
    if "supply" not in inputs:
        return Supply(time_s=np.zeros(1), power_w=np.full(1, np.inf))
    table = tables.read(schemas.SUPPLY, inputs["supply"] / "supply.parquet")
    return Supply(time_s=table["time_s"], power_w=table["battery_power_w"])
