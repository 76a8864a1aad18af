"""Ensemble: the study's charges over samples of the estimated parameters in; the numbers of their summaries out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.comparison import compared
from pipeline.charge.ensemble import EnsembleSettings, draw, with_values
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, Task, simulate_many
from pipeline.errors import UserError
from pipeline.experiments.charges.charge import supply
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.digest import canonical

Row = tuple[int, str, str, str, float | None]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge every sample in every comparison and mode."""
    chosen = EnsembleSettings.model_validate(settings["ensemble"])
    samples = draw(settings["ranges"], settings["followers"], chosen.samples, settings["seed"])
    nominal = {name: settings[name] for name in ("battery", "modes", "charge")}
    source = supply(inputs)
    rows: list[Row] = []
    for number, values in enumerate(samples):
        tree = with_values(nominal, values)
        rows += [(number, *row) for row in _charges(settings, tree, source)]
        print(f"sample {number + 1} of {len(samples)}", flush=True)
    output.rows("ensemble", rows)


def _charges(
    settings: Mapping[str, Any], tree: Mapping[str, Any], source: Supply
) -> Iterator[tuple[str, str, str, float | None]]:
    battery = Battery.model_validate(tree["battery"])
    charge = ChargeSettings.model_validate(tree["charge"])
    engine = EngineSettings.model_validate(settings["engine"])
    modes = {name: Mode.model_validate(mode) for name, mode in tree["modes"].items()}
    wanted: list[tuple[str, str, str]] = []
    tasks: dict[str, Task] = {}
    for comparison, reference in settings["comparisons"].items():
        for name in settings["run"]:
            mode = compared(
                modes[name], None if reference is None else modes[reference], battery, settings["stops"].get(comparison)
            )
            sheet = canonical([name, mode.model_dump(mode="json")])
            wanted.append((comparison, name, sheet))
            if sheet not in tasks and _accepted(battery, mode, charge):
                tasks[sheet] = Task(battery, mode, source, charge, engine)
    summaries = {sheet: done.summary for sheet, done in zip(tasks, simulate_many(tasks.values()), strict=True)}
    for comparison, name, sheet in wanted:
        for quantity in summaries.get(sheet, []):
            if quantity.text is None:
                yield comparison, name, quantity.quantity, quantity.value


def _accepted(battery: Battery, mode: Mode, charge: ChargeSettings) -> bool:
    """Tell whether a charger would accept a sample."""
    try:
        check(battery, mode, charge)
    except UserError:
        return False
    return True
