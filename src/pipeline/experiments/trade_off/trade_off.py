"""Trade-off: a battery, the modes that sample it and what to try in; charge time against peak temperature out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.experiments.trade_off.records import TradeOff
from pipeline.experiments.trade_off.summary import quantities, trade_off
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge by everything that is to be compared."""
    chosen = TradeOff.model_validate(settings["trade_off"])
    rows = trade_off(
        Battery.model_validate(settings["battery"]),
        {name: Mode.model_validate(mode) for name, mode in settings["modes"].items()},
        ChargeSettings.model_validate(settings["charge"]),
        EngineSettings.model_validate(settings["engine"]),
        chosen,
    )
    output.rows("trade_off", rows)
    output.numbers(quantities(rows, chosen))
