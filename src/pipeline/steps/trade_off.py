"""Trade-off: a battery, the modes that sample it and what to try in; charge time against peak temperature out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import quantity, schemas, schemas_trade_off, tables
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.trade_off import Row, trade_off
from pipeline.charge.trade_off_records import TradeOff
from pipeline.charge.trade_off_summary import quantities


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Charge by everything that is to be compared."""
    chosen = TradeOff.model_validate(settings["trade_off"])
    rows = trade_off(
        Battery.model_validate(settings["battery"]),
        {name: Mode.model_validate(mode) for name, mode in settings["modes"].items()},
        ChargeSettings.model_validate(settings["charge"]),
        EngineSettings.model_validate(settings["engine"]),
        chosen,
    )
    columns = {name: [getattr(row, name) for row in rows] for name in Row._fields}
    tables.write(schemas_trade_off.TRADE_OFF, columns, output / "trade_off.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(quantities(rows, chosen)), output / "quantities.parquet")
