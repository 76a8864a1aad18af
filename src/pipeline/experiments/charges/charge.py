"""Charge: one battery, one mode, one supply in; the trace, the enlarged windows, the summary and the energies out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, simulate
from pipeline.kernel.artefacts import Inputs, Output


def supply(inputs: Inputs) -> Supply:
    """Return the power at the battery's terminals; without a supply step, a bench supply that gives any."""
    if "supply" not in inputs:
        return Supply(time_s=np.zeros(1), power_w=np.full(1, np.inf))
    table = inputs.table("supply", "supply")
    return Supply(time_s=table["time_s"], power_w=table["battery_power_w"])


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge the battery and write what came of it."""
    charge = simulate(
        Battery.model_validate(settings["battery"]),
        Mode.model_validate(settings["mode"]),
        supply(inputs),
        ChargeSettings.model_validate(settings["charge"]),
        EngineSettings.model_validate(settings["engine"]),
    )
    output.write("trace", charge.trace)
    output.write("waveform", charge.waveform)
    output.rows("summary", charge.summary)
    output.write("phases", charge.phases)
    output.write("energy", charge.energy)
