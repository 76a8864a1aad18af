"""What the terminal says at the end of a fit: how well the measurement is met, what it does not tell, the card."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.experiments.own_battery.tables import FITTED, READ
from pipeline.kernel.publish import made, view_folder
from pipeline.kernel.tables import TableFile


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield what came of the fit of a run whose artefacts are in the store.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    fitted = partial(_rows, run, results, "own_fit")
    errors = list(fitted(FITTED["errors"], "part", "file", "quantity", "unit", "rmse"))
    if "own_fit" not in steps or not errors:
        return
    names = [str(name) for (name,) in _rows(run, results, "own_reading", READ["files"], "name")]
    for part, place, quantity, unit, rmse in errors:
        if quantity != "temperature":
            yield f"{part}: {quantity} of {names[int(place)]} met to {1e3 * float(rmse):.3g} m{unit} (rmse)"
    for place, freed, rmse in fitted(FITTED["limits"], "file", "freed", "rmse_v"):
        yield f"held out, {names[int(place)]}, with {freed} found from it: {1e3 * float(rmse):.3g} mV"
    told = fitted(FITTED["parameters"], "path", "how", "identified")
    untold = [str(path) for path, _, identified in told if ".value." not in str(path) and not identified]
    if untold:
        yield f"not told by the measurement: {', '.join(untold)}"
    yield f"the card: {view_folder(results, run, 'results') / 'battery.yaml'}"


def _rows(
    run: Mapping[str, Any], results: Path, step: str, file: TableFile, *columns: str
) -> Iterator[tuple[Any, ...]]:
    for _, found in made(run, step, file, results):
        yield from zip(*(found[column].tolist() for column in columns), strict=True)
