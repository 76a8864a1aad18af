"""Search ensemble: the parameter design and the searches with other seeds; what statements on them read out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.experiments.frequency import tuning
from pipeline.experiments.frequency.outcome import outcome
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.optimum import objective_of
from pipeline.objective.records import Problem
from pipeline.published import ensemble
from pipeline.published.words import SEEDS
from pipeline.search.registry import replicated, settings_from

RESAMPLES = 500
"""Of the bootstrap behind each interval; the study's own has four times as many, which takes most of its time."""


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Repeat both, each time with a seed of its own and otherwise as the study has them."""
    rows: list[ensemble.Row] = []
    drawn = ensemble.seeds(settings["seed"], settings["experiments"])
    for number, seed in enumerate(drawn):
        found: dict[str, Mapping[str, Mapping[str, Any]]] = {
            "search": {"quantities": _searched(settings["search"], seed)}
        }
        if settings["tuning"] is not None:
            kept = ensemble.Kept()
            tuning.run({**settings["tuning"], "seed": seed}, inputs, kept)
            found["tuning"] = kept.tables
        reader = ensemble.reader(found)
        rows += ensemble.answers(number, settings["asked"], reader, SEEDS)
        print(f"experiment {number + 1} of {len(drawn)}", flush=True)
    output.rows("ensemble", rows)


def _searched(settings: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """Return the named numbers of the searches; brute force draws nothing, and every pair of searches is its own."""
    objective = objective_of(Problem.model_validate(settings["problem"]))
    histories = {
        item["name"]: replicated(objective, settings_from(item["settings"]), seed) for item in settings["searches"]
    }
    return ensemble.numbers_table(outcome(histories, seed, first_only=True, resamples=RESAMPLES).quantities)
