"""Network kernels: surfaces and the settings of the selections in; the error under every kernel on each of them out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import quantity, schemas, schemas_network, tables
from pipeline.grnn.comparison import varieties
from pipeline.grnn.records import FormSettings, KernelStudy
from pipeline.grnn.summary import of_varieties
from pipeline.search.genetic import GeneticSettings
from pipeline.steps import networks


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Select centres by the genetic algorithm under every kernel on every surface."""
    form, genetic = FormSettings.model_validate(settings["form"]), GeneticSettings.model_validate(settings["genetic"])
    study = KernelStudy.model_validate(settings["kernels"])
    surfaces = {name: data for name, data in networks.surfaces(inputs["surface"]).items() if name != networks.LEARNT}
    found = list(varieties(form, genetic, study, surfaces, int(settings["seed"])))
    rows = [
        (one.surface, one.kernel, *one.widths, replicate, error)
        for one in found
        for replicate, error in enumerate(one.error.tolist())
    ]
    names = ("surface", "kernel", "width_temperature", "width_gradient", "replicate", "mse")
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    tables.write(schemas_network.KERNELS, columns, output / "kernels.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(of_varieties(found)), output / "quantities.parquet")
