"""Networks, their data and the paper's tables of them, as files: read and written in one place."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from pipeline import schemas_network, tables
from pipeline.errors import UserError, best_matches
from pipeline.grnn.network import KERNELS, Network, make_network
from pipeline.grnn.records import Data, data_of
from pipeline.grnn.surfaces import Printed
from pipeline.published.reference import REFERENCE

LEARNT = "learnt"
"""Name of the data that the network learns, among the surfaces."""
_PAIRS = ("widths", "scales", "low", "high")
_COLUMNS = {
    "widths": ("width_temperature", "width_gradient"),
    "scales": ("scale_temperature", "scale_gradient"),
    "low": ("lowest_temperature_c", "lowest_gradient"),
    "high": ("highest_temperature_c", "highest_gradient"),
}


def columns(networks: Mapping[str, tuple[Network, np.ndarray[Any, Any]]]) -> dict[str, Any]:
    """Return networks, each with its rows of the data from 0, as columns of `schemas_network.NETWORKS`."""
    found: dict[str, list[Any]] = {column.name: [] for column in schemas_network.NETWORKS.columns}
    for name, (network, rows) in networks.items():
        for centre in range(network.centre_count):
            values = {
                "network": name, "centre": centre + 1, "row": int(rows[centre]) + 1,
                "temperature_c": network.centres[centre, 0], "gradient": network.centres[centre, 1],
                "rate_c": network.outputs[centre], "kernel": KERNELS[network.kernel], "extension": network.extension,
                "gradient_seconds": network.gradient_seconds,
            }  # fmt: skip
            for pair in _PAIRS:
                values |= dict(zip(_COLUMNS[pair], getattr(network, pair).tolist(), strict=True))
            for key, value in values.items():
                found[key].append(value)
    return found


def read(folder: Path, name: str) -> Network:
    """Return a network of the artefact of the step `network`.

    Arguments
    ---------
    folder : the artefact's.
    name : of the network: the method by which its centres were selected.

    Raises
    ------
    UserError : no such network.
    """
    table = tables.read(schemas_network.NETWORKS, folder / "networks.parquet")
    rows = table["network"] == name
    if not np.any(rows):
        raise UserError(f"no network {name!r}; {best_matches(name, set(map(str, table['network'])))}")
    own = {key: values[rows] for key, values in table.items()}
    pairs = {pair: [float(own[key][0]) for key in _COLUMNS[pair]] for pair in _PAIRS}
    return make_network(
        np.column_stack([own["temperature_c"], own["gradient"]]),
        own["rate_c"],
        widths=pairs["widths"],
        scales=pairs["scales"],
        kernel=cast(Any, str(own["kernel"][0])),
        extension=float(own["extension"][0]),
        low=pairs["low"],
        high=pairs["high"],
        gradient_seconds=float(own["gradient_seconds"][0]),
    )


def surfaces(folder: Path) -> dict[str, Data]:
    """Return the data of every surface in the artefact of the step `surface`, `LEARNT` among them."""
    table = tables.read(schemas_network.SURFACE, folder / "surface.parquet")
    found = {}
    for name in dict.fromkeys(map(str, table["surface"])):
        own = {key: values[table["surface"] == name] for key, values in table.items()}
        seconds = float(own["gradient_seconds"][0])
        found[name] = data_of(own["temperature_c"], own["gradient"], own["rate_c"], seconds)
    return found


def printed_rows() -> list[Printed]:
    """Return those rows of the paper's Table II that are legible as a whole."""
    found = []
    for row in _csv("nicd_table2"):
        numbers = [row[key] for key in ("temperature_c", "gradient", "rate_c")]
        if all(numbers):
            temperature, gradient, rate = map(float, numbers)
            found.append(Printed(int(row["row"]), temperature, gradient, rate, row["certainty"]))
    return found


def printed_temperatures() -> set[float]:
    """Return the temperatures legible in the paper's Table II, also of rows that are not as a whole [degC]."""
    return {float(row["temperature_c"]) for row in _csv("nicd_table2") if row["temperature_c"]}


def printed_mse() -> float:
    """Return the error that the paper's Table III prints for its network [C-rate^2]."""
    return next(float(row["mse"]) for row in _csv("nicd_table3") if row["network"] == "GA-trained GRNN")


def _csv(name: str) -> list[dict[str, str]]:
    with (REFERENCE / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
