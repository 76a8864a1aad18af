"""Objective ensemble: losses against frequency over points of the estimated parameters; what statements read out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.experiments.frequency.choices import objective_settings
from pipeline.experiments.frequency.objective import of_modes, quantities
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.records import Pairs, ReflexFrequency
from pipeline.published import ensemble
from pipeline.published.artefacts import Lookup


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Compute the numbers of the objective in every point."""
    points = ensemble.draw(settings["estimated"], settings["points"], settings["seed"])
    output.rows(
        "ensemble", [row for number, values in enumerate(points) for row in _of_point(settings, number, values)]
    )


def _of_point(settings: Mapping[str, Any], point: int, values: Mapping[str, float]) -> Iterator[ensemble.Row]:
    tree = ensemble.with_values({name: settings[name] for name in ("battery", "modes", "objective")}, values)
    try:
        reader: Lookup | None = _reader(tree)
    except ensemble.IMPOSSIBLE:
        reader = None
    yield from ensemble.answers(point, settings["asked"], reader)


def _reader(tree: Mapping[str, Any]) -> Lookup:
    config = SimpleNamespace(
        battery=Battery.model_validate(tree["battery"]),
        modes={name: Mode.model_validate(mode) for name, mode in tree["modes"].items()},
        objective=ReflexFrequency.model_validate(tree["objective"]),
    )
    found = objective_settings(config, config.modes)
    pairs, waveforms = Pairs(*(tuple(part) for part in found["pairs"])), found["waveforms"]
    numbers = [
        *quantities(
            config.objective,
            waveforms[config.objective.mode],
            pairs,
            found["series_resistance_ohm"],
            found["thermal_resistance_k_w"],
        ),
        *of_modes(config.objective, waveforms, pairs),
    ]
    return ensemble.reader({"objective": {"quantities": ensemble.numbers_table(numbers)}})
