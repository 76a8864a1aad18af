"""Network size: data and the settings of the selections in; the error against the number of centres out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import quantity, schemas, schemas_network, tables
from pipeline.grnn.comparison import sizes, units
from pipeline.grnn.records import FormSettings, SizeStudy
from pipeline.grnn.summary import of_sizes
from pipeline.search.genetic import GeneticSettings
from pipeline.steps import networks


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Select ever more centres, by the genetic algorithm and by forward selection."""
    form, genetic = FormSettings.model_validate(settings["form"]), GeneticSettings.model_validate(settings["genetic"])
    data = networks.surfaces(inputs["surface"])[networks.LEARNT]
    found = list(sizes(form, genetic, SizeStudy.model_validate(settings["size"]), data, int(settings["seed"])))
    rows: list[tuple[Any, ...]] = []
    for one in found:
        both = (("genetic", one.error.tolist()), ("forward", [one.forward_error]))
        rows += [
            (one.centres, units(one.centres), method, replicate, error)
            for method, errors in both
            for replicate, error in enumerate(errors)
        ]
    names = ("centres", "units", "method", "replicate", "mse")
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    tables.write(schemas_network.SIZES, columns, output / "sizes.parquet")
    numbers = quantity.columns(of_sizes(found, networks.printed_mse()))
    tables.write(schemas.QUANTITIES, numbers, output / "quantities.parquet")
