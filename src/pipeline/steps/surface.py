"""Surface: where the data come from in; the data, every surface that could be meant, and the printed rows out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import digest, quantity, schemas, schemas_network, tables
from pipeline.errors import UserError
from pipeline.grnn.records import Data, DataSettings
from pipeline.grnn.summary import of_surfaces
from pipeline.grnn.surfaces import GRADIENT_SECONDS, Agreement, agreements, every_surface
from pipeline.steps import networks, own_table


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Make the surfaces and hold them against the paper's Table II."""
    chosen = DataSettings.model_validate(settings["data"])
    surfaces = every_surface(chosen)
    learnt, name = surfaces[chosen.surface], str(chosen.surface)
    if chosen.table is not None:
        learnt, name = _own(chosen, settings["table_sha256"]), "table"
    found = agreements(chosen, networks.printed_rows())
    everything = {networks.LEARNT: learnt, **surfaces}
    tables.write(schemas_network.SURFACE, _points(everything), output / "surface.parquet")
    tables.write(schemas_network.SURFACE_AGREEMENT, _agreements(found), output / "printed.parquet")
    numbers = of_surfaces(learnt, surfaces, found, name)
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _own(chosen: DataSettings, expected: str) -> Data:
    """Read a person's own table, if it is still the one that was planned with."""
    path = Path(str(chosen.table))
    data = own_table.read(path, GRADIENT_SECONDS[chosen.gradient_unit])
    if digest.of_file(path) != expected:
        raise UserError(f"{path}: changed since the run was planned; run again")
    return data


def _points(surfaces: Mapping[str, Data]) -> dict[str, Any]:
    return {
        "surface": np.concatenate([np.full(len(data.rate), name, dtype=object) for name, data in surfaces.items()]),
        "temperature_c": np.concatenate([data.inputs[:, 0] for data in surfaces.values()]),
        "gradient": np.concatenate([data.inputs[:, 1] for data in surfaces.values()]),
        "rate_c": np.concatenate([data.rate for data in surfaces.values()]),
        "gradient_seconds": np.concatenate(
            [np.full(len(data.rate), data.gradient_seconds) for data in surfaces.values()]
        ),
    }


def _agreements(found: list[Agreement]) -> dict[str, Any]:
    return {
        "surface": [one.surface for one in found],
        "row": [one.printed.row for one in found],
        "certainty": [one.printed.certainty for one in found],
        "temperature_c": [one.printed.temperature_c for one in found],
        "gradient": [one.printed.gradient for one in found],
        "printed_rate_c": [one.printed.rate_c for one in found],
        "computed_rate_c": [one.computed_c for one in found],
        "consistent": [one.consistent for one in found],
    }
