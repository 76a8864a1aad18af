"""What the terminal says at the end of a fit: how well the measurement is met, what it does not tell, the card."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.experiments.own_battery.tables import FITTED, READ
from pipeline.kernel import store, tables
from pipeline.kernel.publish import view_folder


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield what came of the fit of a run whose artefacts are in the store.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    node = run["nodes"].get("own_fit")
    if node is None or "own_fit" not in steps:
        return
    folder = store.artefact(results, node["step"], node["key"])
    if not (folder / FITTED["errors"].file).is_file():
        return
    names = [str(name) for name in _names(run, results)]
    for part, place, quantity, unit, rmse in _rows(folder, "errors", "part", "file", "quantity", "unit", "rmse"):
        if quantity != "temperature":
            yield f"{part}: {quantity} of {names[int(place)]} met to {1e3 * float(rmse):.3g} m{unit} (rmse)"
    for place, freed, rmse in _rows(folder, "limits", "file", "freed", "rmse_v"):
        yield f"held out, {names[int(place)]}, with {freed} found from it: {1e3 * float(rmse):.3g} mV"
    told = _rows(folder, "parameters", "path", "how", "identified")
    untold = [str(path) for path, _, identified in told if ".value." not in str(path) and not identified]
    if untold:
        yield f"not told by the measurement: {', '.join(untold)}"
    yield f"the card: {view_folder(results, run, 'results') / 'battery.yaml'}"


def _names(run: Mapping[str, Any], results: Path) -> list[Any]:
    node, file = run["nodes"]["own_reading"], READ["files"]
    found = tables.read(file.table, store.artefact(results, node["step"], node["key"]) / file.file)
    return list(found["name"].tolist())


def _rows(folder: Path, name: str, *columns: str) -> list[tuple[Any, ...]]:
    file = FITTED[name]
    found = tables.read(file.table, folder / file.file)
    return list(zip(*(found[column].tolist() for column in columns), strict=True))
