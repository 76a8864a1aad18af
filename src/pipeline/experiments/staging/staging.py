"""Staging: the searches' runs in; the best currents, those that others ask for, and what it all comes to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.experiments.staging.optimum import convex_share, problem_of
from pipeline.experiments.staging.records import READINGS, Reading, StagingProblem, Weights
from pipeline.experiments.staging.stage_charges import Charges
from pipeline.experiments.staging.summary import PRINTED, Case, Found, best_cases, constants, quantities, starts_of
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Hold the searches against the local solver, and write the currents that charges ask for."""
    asked = StagingProblem.model_validate(settings["problem"])
    problem = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    weights = {item["name"]: Weights(time=item["time"], rise=item["rise"]) for item in settings["weights"]}
    printed, use, seed = np.array(asked.plan.currents_a), str(settings["use"]), int(settings["seed"])
    starts = starts_of(problem, int(settings["starts"]), seed)
    listed = [Case(PRINTED, printed, "the paper")]
    listed += [_found(inputs, name, use, asked.rise) for name in weights]
    cases = {case.name: case for case in [*listed, *best_cases(problem, weights, printed, starts)]}
    first = next(iter(weights))
    runs = {name: inputs.table(f"staging_search/{first}/{name}", "runs") for name in settings["searches"]}
    baselines = constants(problem, printed)
    random = np.random.default_rng(np.random.SeedSequence([seed, 1]))
    convex = convex_share(problem, int(settings["chords"]), random) if settings["chords"] else np.nan
    found = Found(problem, printed, weights, cases, baselines, runs, use, convex, int(settings["evaluations"]))
    charged = {name: case.charged(problem) for name, case in cases.items()}
    output.rows("cases", _cases(cases, charged))
    output.rows("currents", _currents(cases, charged, asked.plan.soc_edges))
    output.numbers(quantities(found, random))
    named = {"found": first, "same_peak": "same_peak", "same_final": "same_final"}
    lists = {f"{name}_currents_a": cases[case].currents_a.tolist() for name, case in named.items()}
    output.found(lists | {f"constant_{name}_a": constant.current_a for name, constant in baselines.items()})


def _found(inputs: Inputs, weights: str, use: str, reading: Reading) -> Case:
    """Return the best that the search found for some weights."""
    runs, currents = (inputs.table(f"staging_search/{weights}/{use}", name) for name in ("runs", "run_currents"))
    best = runs["replicate"][int(np.argmin(runs["value"]))]
    return Case(weights, currents["current_a"][currents["replicate"] == best], use, weights, reading)


def _cases(cases: Mapping[str, Case], charged: Mapping[str, Charges]) -> Iterator[tuple[Any, ...]]:
    for name, case in cases.items():
        come_to = charged[name]
        rises = (float(come_to.rise_k(reading)[0]) for reading in READINGS)
        named = (name, case.weights, case.reading, case.found_by)
        yield (*named, float(come_to.time_s[0]), *rises, float(come_to.peak_v.max()))


def _currents(
    cases: Mapping[str, Case], charged: Mapping[str, Charges], edges: Sequence[float]
) -> Iterator[tuple[Any, ...]]:
    for name, case in cases.items():
        for stage, current in enumerate(case.currents_a):
            length_s, rise_k = charged[name].stage_s[0, stage], charged[name].end_k[0, stage]
            window = (edges[stage], edges[stage + 1])
            yield (name, stage + 1, *window, float(current), float(length_s), float(rise_k))
