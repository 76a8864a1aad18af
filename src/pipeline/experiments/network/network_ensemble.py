"""Network ensemble: the errors of every selection's runs in; what statements read of resampled runs out.

A selection takes minutes to repeat. Its runs are independent, of a seed each, so that as many of them drawn with
replacement stand in for an experiment with other seeds (Efron 1979, DOI 10.1214/aos/1176344552).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.experiments.network.numbers import NETWORK, SIZES
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published import ensemble
from pipeline.published.words import RESAMPLED
from pipeline.quantity import Quantity

Errors = dict[str, np.ndarray[Any, Any]]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Draw the runs of every method and size anew, many times."""
    selected = _errors(inputs.table("network", "selections"), "method")
    sizes = inputs.table("network_size", "sizes") if "network_size" in inputs else None
    genetic = {} if sizes is None else _errors(_of(sizes, "method", "genetic"), "centres")
    own = [Quantity(name, value, "1", "") for name, value in _unchanged(inputs.numbers("network")).items()]
    rows: list[ensemble.Row] = []
    for number, seed in enumerate(ensemble.seeds(settings["seed"], settings["experiments"])):
        rng = np.random.default_rng(seed)
        found = {"network": {"quantities": ensemble.numbers_table([*own, *_of_methods(selected, rng)])}}
        if genetic:
            found["network_size"] = {"quantities": ensemble.numbers_table(_of_sizes(genetic, rng))}
        reader = ensemble.reader(found)
        rows += ensemble.answers(number, settings["asked"], reader, RESAMPLED)
    output.rows("ensemble", rows)


def _unchanged(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return what other seeds do not change, or what is computed once: all but the medians over the runs."""
    return {name: value for name, value in numbers.items() if not name.endswith("_mse_median")}


def _errors(columns: Mapping[str, Any], by: str) -> Errors:
    """Return the errors of a table's runs by the words in one of its columns."""
    names = columns[by].astype(str)
    return {str(name): columns["mse"][names == name] for name in np.unique(names)}


def _of(columns: Mapping[str, Any], name: str, wanted: str) -> dict[str, Any]:
    chosen = columns[name] == wanted
    return {key: column[chosen] for key, column in columns.items()}


def _median(errors: np.ndarray[Any, Any], rng: np.random.Generator) -> float:
    return float(np.median(rng.choice(errors, len(errors))))


def _of_methods(errors: Errors, rng: np.random.Generator) -> Iterator[Quantity]:
    for method, own in errors.items():
        yield NETWORK.quantity("{method}_mse_median", _median(own, rng), method=method)


def _of_sizes(errors: Errors, rng: np.random.Generator) -> Iterator[Quantity]:
    for size, own in errors.items():
        yield SIZES.quantity("size_{size}_mse_median", _median(own, rng), size=size)
