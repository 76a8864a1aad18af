"""Network: data and the settings of the selections in; the networks, their errors and how they were found out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.experiments.network import sources
from pipeline.experiments.network.comparison import Comparison, after, compare
from pipeline.experiments.network.records import LONG, USED, FormSettings, SelectionSettings
from pipeline.experiments.network.summary import of_networks
from pipeline.grnn import anfis
from pipeline.grnn.charger_network import charger_network
from pipeline.grnn.error import network_of
from pipeline.grnn.network import KERNELS, Network, responses
from pipeline.grnn.records import AnfisSettings, Data
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.draft import plain
from pipeline.search.genetic import Course

Selected = dict[str, tuple[Network, np.ndarray[Any, Any]]]
"""Name of a network -> the network, and its rows of the data from 0."""


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Select centres by every method, and train the neuro-fuzzy peer."""
    form, seed = FormSettings.model_validate(settings["form"]), int(settings["seed"])
    selection = SelectionSettings.model_validate(settings["selection"])
    data = sources.surfaces(inputs)[sources.LEARNT]
    found = compare(form, selection, data, seed)
    learning = anfis.learn(data, AnfisSettings.model_validate(settings["anfis"]))
    best = _best(selection, data, found)
    printed, mse = sources.printed_temperatures(), sources.printed_mse()
    output.rows("networks", _centres(best))
    output.found({name: plain(charger_network(network)) for name, (network, _) in best.items()})
    output.rows("selections", _selections(found))
    output.rows("trials", _trials(found))
    output.write("course", _course(found.course))
    output.write("response", _response(data, best[USED][0], learning.system))
    output.write("learning", {"epoch": np.arange(1, len(learning.error) + 1), "mse": learning.error})
    output.numbers(of_networks(form, selection, data, found, learning, printed, mse, seed))


def _best(selection: SelectionSettings, data: Data, found: Comparison) -> Selected:
    """Return the best network of each method, its centres in the order of the data."""
    chosen = {str(name): (result.form, result.selected) for name, result in found.results.items()}
    chosen[LONG] = (found.results[USED].form, after(found.course, selection.long_generations))
    rows = {name: np.sort(selected.best()) for name, (_, selected) in chosen.items()}
    return {name: (network_of(data, form, rows[name]), rows[name]) for name, (form, _) in chosen.items()}


def _centres(networks: Selected) -> Iterator[tuple[Any, ...]]:
    """Yield the rows of the table `networks`: a row per network and centre."""
    for name, (network, rows) in networks.items():
        shared = (
            KERNELS[network.kernel],
            *network.widths.tolist(),
            *network.scales.tolist(),
            network.extension,
            *(end for pair in zip(network.low.tolist(), network.high.tolist(), strict=True) for end in pair),
            network.gradient_seconds,
        )
        for centre, (place, rate, row) in enumerate(zip(network.centres, network.outputs, rows, strict=True)):
            yield (name, centre + 1, int(row) + 1, *place.tolist(), float(rate), *shared)


def _selections(found: Comparison) -> Iterator[tuple[Any, ...]]:
    for method, result in found.results.items():
        for replicate, error in enumerate(result.selected.error.tolist()):
            yield (method, replicate, error, result.selected.evaluations)


def _trials(found: Comparison) -> Iterator[tuple[Any, ...]]:
    for method, result in found.results.items():
        yield from ((method, *trial.widths, trial.error) for trial in result.trials)


def _course(course: Course) -> dict[str, Any]:
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
