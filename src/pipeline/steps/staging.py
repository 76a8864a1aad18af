"""Staging: the searches' runs in; the best currents, those that others ask for, and what it all comes to."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import quantity, schemas, tables
from pipeline import schemas_staging as declared
from pipeline.objective.staging import Charges
from pipeline.objective.staging_cases import PRINTED, Case, best_cases, constants, starts_of
from pipeline.objective.staging_optimum import convex_share
from pipeline.objective.staging_records import READINGS, StagingProblem, Weights
from pipeline.objective.staging_runs import problem_of
from pipeline.objective.staging_summary import Found, quantities
from pipeline.steps import found as found_file


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Hold the searches against the local solver, and write the currents that charges ask for."""
    asked = StagingProblem.model_validate(settings["problem"])
    problem = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    weights = {item["name"]: Weights(time=item["time"], rise=item["rise"]) for item in settings["weights"]}
    printed, use, seed = np.array(asked.plan.currents_a), str(settings["use"]), int(settings["seed"])
    starts = starts_of(problem, int(settings["starts"]), seed)
    listed = [Case(PRINTED, printed, "the paper")]
    listed += [_found(name, use, asked.rise, inputs[f"staging_search/{name}/{use}"]) for name in weights]
    cases = {case.name: case for case in [*listed, *best_cases(problem, weights, printed, starts)]}
    first = next(iter(weights))
    runs = {
        name: tables.read(declared.STAGING_RUNS, inputs[f"staging_search/{first}/{name}"] / "runs.parquet")
        for name in settings["searches"]
    }
    baselines = constants(problem, printed)
    random = np.random.default_rng(np.random.SeedSequence([seed, 1]))
    convex = convex_share(problem, int(settings["chords"]), random) if settings["chords"] else np.nan
    found = Found(problem, printed, weights, cases, baselines, runs, use, convex, int(settings["evaluations"]))
    charged = {name: case.charged(problem) for name, case in cases.items()}
    edges = asked.plan.soc_edges
    tables.write(declared.STAGING_CASES, _cases(cases, charged), output / "cases.parquet")
    tables.write(declared.STAGING_CURRENTS, _currents(cases, charged, edges), output / "currents.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(quantities(found, random)), output / "quantities.parquet")
    named = {"found": first, "same_peak": "same_peak", "same_final": "same_final"}
    values = {
        f"{name}_{n}_a": float(current)
        for name, case in named.items()
        for n, current in enumerate(cases[case].currents_a, start=1)
    }
    values |= {f"constant_{name}_a": constant.current_a for name, constant in baselines.items()}
    found_file.write(values, output)


def _found(weights: str, use: str, reading: Any, folder: Path) -> Case:
    """Return the best that the search found for some weights."""
    runs = tables.read(declared.STAGING_RUNS, folder / "runs.parquet")
    currents = tables.read(declared.STAGING_RUN_CURRENTS, folder / "run_currents.parquet")
    best = runs["replicate"][int(np.argmin(runs["value"]))]
    return Case(weights, currents["current_a"][currents["replicate"] == best], use, weights, reading)


def _cases(cases: Mapping[str, Case], charged: Mapping[str, Charges]) -> dict[str, list[Any]]:
    rises = {f"{one}_k": [float(charged[name].rise_k(one)[0]) for name in cases] for one in READINGS}
    return {
        "case": list(cases),
        "weights": [case.weights for case in cases.values()],
        "rise": [case.reading for case in cases.values()],
        "found_by": [case.found_by for case in cases.values()],
        "time_s": [float(charged[name].time_s[0]) for name in cases],
        **rises,
        "peak_v": [float(charged[name].peak_v.max()) for name in cases],
    }


def _currents(cases: Mapping[str, Case], charged: Mapping[str, Charges], edges: list[float]) -> dict[str, list[Any]]:
    stages = range(len(edges) - 1)
    rows = [(name, stage) for name in cases for stage in stages]
    return {
        "case": [name for name, _ in rows],
        "stage": [stage + 1 for _, stage in rows],
        "soc_from": [edges[stage] for _, stage in rows],
        "soc_to": [edges[stage + 1] for _, stage in rows],
        "current_a": [float(cases[name].currents_a[stage]) for name, stage in rows],
        "length_s": [float(charged[name].stage_s[0, stage]) for name, stage in rows],
        "rise_k": [float(charged[name].end_k[0, stage]) for name, stage in rows],
    }
