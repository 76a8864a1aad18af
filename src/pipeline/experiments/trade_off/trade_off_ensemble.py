"""Trade-off ensemble: time against temperature over points of the estimated parameters; what statements read out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.experiments.trade_off.records import TradeOff
from pipeline.experiments.trade_off.summary import quantities, trade_off
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published import ensemble
from pipeline.published.artefacts import Lookup


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Weigh time against temperature in every point, in the first of the conditions."""
    points = ensemble.draw(settings["estimated"], settings["points"], settings["seed"])
    rows: list[ensemble.Row] = []
    for number, values in enumerate(points):
        try:
            reader: Lookup | None = _reader(settings, values)
        except ensemble.IMPOSSIBLE:
            reader = None
        rows += ensemble.answers(number, settings["asked"], reader)
        print(f"{number + 1} of {len(points)} points", flush=True)
    output.rows("ensemble", rows)


def _reader(settings: Mapping[str, Any], values: Mapping[str, float]) -> Lookup:
    parts = ("battery", "modes", "charge", "trade_off")
    tree = ensemble.with_values({name: settings[name] for name in parts}, values)
    charge = ChargeSettings.model_validate(tree["charge"])
    chosen = TradeOff.model_validate(tree["trade_off"])
    first, condition = next(iter(chosen.conditions.items()))
    # The first condition is the study's own, whose start is an estimate of the charges.
    there = condition.model_copy(update={"initial_soc": charge.initial_soc, "ambient_c": charge.ambient_c})
    chosen = chosen.model_copy(update={"conditions": {first: there}, "sensors": {}})
    rows = trade_off(
        Battery.model_validate(tree["battery"]),
        {name: Mode.model_validate(mode) for name, mode in tree["modes"].items()},
        charge,
        EngineSettings.model_validate(settings["engine"]),
        chosen,
    )
    numbers = ensemble.numbers_table(quantities(rows, chosen))
    return ensemble.reader({"trade_off": {"quantities": numbers}})
