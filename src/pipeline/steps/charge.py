"""Charge: one battery, one mode, one supply in; the trace, the enlarged windows, the summary and the energies out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, tables
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import simulate
from pipeline.steps.inputs import supply


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Charge the battery and write what came of it."""
    charge = simulate(
        Battery.model_validate(settings["battery"]),
        Mode.model_validate(settings["mode"]),
        supply(inputs),
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
