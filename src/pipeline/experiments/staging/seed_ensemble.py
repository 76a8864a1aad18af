"""Seed ensemble: the searches for stage currents with other seeds; what statements on them read out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.experiments.staging import summary
from pipeline.experiments.staging.optimum import problem_of
from pipeline.experiments.staging.records import StagingProblem, Weights
from pipeline.experiments.staging.staging_search import searched
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published import ensemble
from pipeline.published.words import SEEDS
from pipeline.search.registry import settings_from


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Repeat the searches that are compared, each time with a seed of its own, at the study's own size."""
    asked = StagingProblem.model_validate(settings["problem"])
    problem = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    first, evaluations = settings["first"], int(settings["evaluations"])
    best = inputs.numbers("staging")[f"{first}_best_value"]
    weights = {first: Weights.model_validate(settings["problem"]["weights"])}
    rows: list[ensemble.Row] = []
    drawn = ensemble.seeds(settings["seed"], settings["experiments"])
    for number, seed in enumerate(drawn):
        runs = {
            one["name"]: searched(asked, settings_from(one["settings"]), evaluations, seed).runs
            for one in settings["searches"]
        }
        found = summary.Found(
            problem, np.array(asked.plan.currents_a), weights, {}, {}, runs, settings["use"], np.nan, evaluations
        )
        numbers = list(summary.of_searches(found, best, np.random.default_rng(seed)))
        tables = {"staging": {"quantities": ensemble.numbers_table(numbers)}}
        rows += ensemble.answers(number, settings["asked"], ensemble.reader(tables), SEEDS)
        print(f"experiment {number + 1} of {len(drawn)}", flush=True)
    output.rows("ensemble", rows)
