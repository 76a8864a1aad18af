"""Network size: data and the settings of the selections in; the error against the number of centres out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.experiments.network import sources
from pipeline.experiments.network.comparison import sizes, units
from pipeline.experiments.network.records import FormSettings, SizeStudy
from pipeline.experiments.network.summary import of_sizes
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.search.genetic import GeneticSettings


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Select ever more centres, by the genetic algorithm and by forward selection."""
    form, genetic = FormSettings.model_validate(settings["form"]), GeneticSettings.model_validate(settings["genetic"])
    data = sources.surfaces(inputs)[sources.LEARNT]
    found = list(sizes(form, genetic, SizeStudy.model_validate(settings["size"]), data, int(settings["seed"])))
    rows: list[tuple[Any, ...]] = []
    for one in found:
        both = (("genetic", one.error.tolist()), ("forward", [one.forward_error]))
        rows += [
            (one.centres, units(one.centres), method, replicate, error)
            for method, errors in both
            for replicate, error in enumerate(errors)
        ]
    output.rows("sizes", rows)
    output.numbers(of_sizes(found, sources.printed_mse()))
