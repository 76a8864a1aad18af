"""Network kernels: surfaces and the settings of the selections in; the error under every kernel on each of them out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.experiments.network import sources
from pipeline.experiments.network.comparison import varieties
from pipeline.experiments.network.records import FormSettings, KernelStudy
from pipeline.experiments.network.summary import of_varieties
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.search.genetic import GeneticSettings


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Select centres by the genetic algorithm under every kernel on every surface."""
    form, genetic = FormSettings.model_validate(settings["form"]), GeneticSettings.model_validate(settings["genetic"])
    study = KernelStudy.model_validate(settings["kernels"])
    surfaces = {name: data for name, data in sources.surfaces(inputs).items() if name != sources.LEARNT}
    found = list(varieties(form, genetic, study, surfaces, int(settings["seed"])))
    rows = (
        (one.surface, one.kernel, *one.widths, replicate, error)
        for one in found
        for replicate, error in enumerate(one.error.tolist())
    )
    output.rows("kernels", rows)
    output.numbers(of_varieties(found))
