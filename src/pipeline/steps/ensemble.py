"""Ensemble: the study's charges over samples of the estimated parameters in; the numbers of their summaries out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, tables
from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.comparison import compared
from pipeline.charge.ensemble import EnsembleSettings, draw, with_values
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Supply, simulate
from pipeline.digest import canonical
from pipeline.errors import UserError
from pipeline.steps.inputs import supply

Row = tuple[int, str, str, str, float | None]


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
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
    names = ("sample", "comparison", "mode", "quantity", "value")
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    tables.write(schemas.ENSEMBLE, columns, output / "ensemble.parquet")


def _charges(
    settings: Mapping[str, Any], tree: Mapping[str, Any], source: Supply
) -> Iterator[tuple[str, str, str, float | None]]:
    battery = Battery.model_validate(tree["battery"])
    charge = ChargeSettings.model_validate(tree["charge"])
    engine = EngineSettings.model_validate(settings["engine"])
    modes = {name: Mode.model_validate(mode) for name, mode in tree["modes"].items()}
    done: dict[str, list[tuple[str, float | None]]] = {}
    for comparison, reference in settings["comparisons"].items():
        for name in settings["run"]:
            mode = compared(
                modes[name], None if reference is None else modes[reference], battery, settings["stops"].get(comparison)
            )
            sheet = canonical([name, mode.model_dump(mode="json")])
            if sheet not in done:
                done[sheet] = _numbers(battery, mode, source, charge, engine)
            yield from ((comparison, name, quantity, value) for quantity, value in done[sheet])


def _numbers(
    battery: Battery, mode: Mode, source: Supply, charge: ChargeSettings, engine: EngineSettings
) -> list[tuple[str, float | None]]:
    """Return the numbers of a charge's summary; none for a sample that no charger would accept."""
    try:
        check(battery, mode, charge)
    except UserError:
        return []
    summary = simulate(battery, mode, source, charge, engine).summary
    return [(quantity.quantity, quantity.value) for quantity in summary if quantity.text is None]
