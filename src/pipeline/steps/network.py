"""Network: data and the settings of the selections in; the networks, their errors and how they were found out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import quantity, schemas, schemas_network, tables
from pipeline.draft import plain
from pipeline.grnn import anfis
from pipeline.grnn.charger_network import charger_network
from pipeline.grnn.comparison import Comparison, after, compare
from pipeline.grnn.error import network_of
from pipeline.grnn.network import Network, responses
from pipeline.grnn.records import LONG, AnfisSettings, Data, FormSettings, SelectionSettings
from pipeline.grnn.summary import of_networks
from pipeline.search.genetic import Course
from pipeline.steps import found as found_values
from pipeline.steps import networks


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Select centres by every method, and train the neuro-fuzzy peer."""
    form, seed = FormSettings.model_validate(settings["form"]), int(settings["seed"])
    selection = SelectionSettings.model_validate(settings["selection"])
    data = networks.surfaces(inputs["surface"])[networks.LEARNT]
    found = compare(form, selection, data, seed)
    learning = anfis.learn(data, AnfisSettings.model_validate(settings["anfis"]))
    best = _best(selection, data, found)
    printed, mse = networks.printed_temperatures(), networks.printed_mse()
    numbers = of_networks(form, selection, data, found, learning, printed, mse, seed)
    tables.write(schemas_network.NETWORKS, networks.columns(best), output / "networks.parquet")
    found_networks = {name: plain(charger_network(network)) for name, (network, _) in best.items()}
    found_values.write(found_networks, output)
    tables.write(schemas_network.SELECTIONS, _selections(found), output / "selections.parquet")
    tables.write(schemas_network.TRIALS, _trials(found), output / "trials.parquet")
    tables.write(schemas_network.HISTORY, _history(found.course), output / "history.parquet")
    response = _response(data, best["genetic"][0], learning.system)
    tables.write(schemas_network.RESPONSE, response, output / "response.parquet")
    epochs = {"epoch": np.arange(1, len(learning.error) + 1), "mse": learning.error}
    tables.write(schemas_network.LEARNING, epochs, output / "learning.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _best(
    selection: SelectionSettings, data: Data, found: Comparison
) -> dict[str, tuple[Network, np.ndarray[Any, Any]]]:
    """Return the best network of each method, its centres in the order of the data."""
    chosen = {str(name): (result.form, result.selected) for name, result in found.results.items()}
    chosen[LONG] = (found.results["genetic"].form, after(found.course, selection.long_generations))
    rows = {name: np.sort(selected.best()) for name, (_, selected) in chosen.items()}
    return {name: (network_of(data, form, rows[name]), rows[name]) for name, (form, _) in chosen.items()}


def _selections(found: Comparison) -> dict[str, list[Any]]:
    rows = [
        (method, replicate, error, result.selected.evaluations)
        for method, result in found.results.items()
        for replicate, error in enumerate(result.selected.error.tolist())
    ]
    return _columns(("method", "replicate", "mse", "evaluations"), rows)


def _trials(found: Comparison) -> dict[str, list[Any]]:
    rows = [(method, *trial.widths, trial.error) for method, result in found.results.items() for trial in result.trials]
    return _columns(("method", "width_temperature", "width_gradient", "mse"), rows)


def _history(course: Course) -> dict[str, Any]:
    table = course.history.columns(())
    return {
        "replicate": table["replicate"],
        "generation": table["iteration"],
        "evaluations": table["evaluations"],
        "best_mse": table["value"],
        "mean_mse": course.mean.ravel(),
    }


def _response(data: Data, network: Network, system: anfis.Anfis) -> dict[str, Any]:
    return {
        "temperature_c": data.inputs[:, 0],
        "gradient": data.inputs[:, 1],
        "rate_c": data.rate,
        "network_c": responses(network, data.inputs),
        "anfis_c": anfis.predict(system, data.inputs),
    }


def _columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> dict[str, list[Any]]:
    return {name: [row[place] for row in rows] for place, name in enumerate(names)}
