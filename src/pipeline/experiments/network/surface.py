"""Surface: where the data come from in; the data, every surface that could be meant, and the printed rows out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import UserError
from pipeline.experiments.network import sources
from pipeline.experiments.network.records import GRADIENT_SECONDS, DataSettings
from pipeline.experiments.network.sources import Agreement, agreements, every_surface
from pipeline.experiments.network.summary import of_surfaces
from pipeline.files import profiles
from pipeline.grnn.records import Data, data_of
from pipeline.kernel import digest
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Make the surfaces and hold them against the paper's Table II."""
    chosen = DataSettings.model_validate(settings["data"])
    surfaces = every_surface(chosen)
    learnt, name = surfaces[chosen.surface], str(chosen.surface)
    if chosen.table is not None:
        learnt, name = _own(chosen, settings["table_sha256"]), "table"
    found = agreements(chosen, sources.printed_rows())
    output.write("surface", _points({sources.LEARNT: learnt, **surfaces}))
    output.write("printed", _agreements(found))
    output.numbers(of_surfaces(learnt, surfaces, found, name))


def _own(chosen: DataSettings, expected: str) -> Data:
    """Read a person's own table, if it is still the one that was planned with."""
    path = Path(str(chosen.table))
    seconds = GRADIENT_SECONDS[chosen.gradient_unit]
    data = data_of(*profiles.read(path, seconds), seconds)
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
