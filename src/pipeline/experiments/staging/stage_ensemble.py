"""Stage ensemble: staged charges over points of the estimated parameters; what statements read of them out.

What a search found stays as it was found, and is charged with in every point; optima and constant currents, which are
computed and not searched for, are those of the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.experiments.staging import summary
from pipeline.experiments.staging.front import evolved_currents
from pipeline.experiments.staging.optimum import Problem, best_weighted, fastest, problem_of
from pipeline.experiments.staging.records import KEPT, READINGS, FrontSettings, StagingProblem, Weights
from pipeline.experiments.staging.stage_charges import charge, fitness, value_of
from pipeline.experiments.staging.vocabulary import FRONT, SEARCHED
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.published import ensemble
from pipeline.published.artefacts import Lookup
from pipeline.quantity import Quantity

Array = NDArray[np.float64]
STARTS = 4
"""Starts of the local solver in a point, fewer than the study's own."""


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge with the printed and with the found currents in every point, and solve for the best."""
    points = ensemble.draw(settings["estimated"], settings["points"], settings["seed"])
    asked = StagingProblem.model_validate(settings["problem"])
    own = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    table = inputs.table("staging", "currents")
    cases = {str(name): table["current_a"][table["case"] == name] for name in np.unique(table["case"].astype(str))}
    how = FrontSettings.model_validate(settings["front"])
    evolved = evolved_currents(own._replace(reading="peak"), how, settings["seed"])
    starts = summary.starts_of(own, STARTS, settings["seed"])
    rows: list[ensemble.Row] = []
    for number, values in enumerate(points):
        rows += ensemble.answers(number, settings["asked"], _reader(settings, values, cases, evolved, starts))
    output.rows("ensemble", rows)


def _reader(
    settings: Mapping[str, Any],
    values: Mapping[str, float],
    cases: Mapping[str, Array],
    evolved: Array,
    starts: Array,
) -> Lookup | None:
    """Return what a point comes to; none where no cell can be so, or where no current keeps to its limits."""
    asked = settings["problem"]
    tree = ensemble.with_values({"battery": asked["battery"], "staging": {"current_a": asked["current_a"]}}, values)
    try:
        there = StagingProblem.model_validate({**asked, "battery": tree["battery"], **tree["staging"]})
        problem = problem_of(there.battery, there.plan, there.current_a, there.rise)
        weights = {one["name"]: Weights(time=one["time"], rise=one["rise"]) for one in settings["weights"]}
        staged = [*_printed(problem, cases), *_weighted(problem, weights, cases, starts), *_kept(problem, cases)]
        front = list(_front(problem, cases, evolved))
    except ensemble.IMPOSSIBLE:
        return None
    found = {"staging": {"quantities": ensemble.numbers_table(staged)}}
    found |= {"front": {"quantities": ensemble.numbers_table(front)}}
    return ensemble.reader(found)


def _printed(problem: Problem, cases: Mapping[str, Array]) -> Iterator[Quantity]:
    printed = cases[summary.PRINTED]
    found = summary.Found(problem, printed, {}, {}, summary.constants(problem, printed), {}, "", np.nan, 0)
    yield from summary.of_printed(found)
    yield from summary.of_baselines(found)


def _weighted(
    problem: Problem, weights: Mapping[str, Weights], cases: Mapping[str, Array], starts: Array
) -> Iterator[Quantity]:
    """Yield what the found currents come to, and for the first weights the least objective there is."""
    scale, ambient_c = problem.scale(), problem.grid.ambient_k - ZERO_CELSIUS_K
    for place, (name, pair) in enumerate(weights.items()):
        number = partial(SEARCHED.quantity, weights=name)
        rows = charge(problem.grid, np.array([cases[summary.PRINTED], cases[name]]))
        values = value_of(rows, scale, pair, problem.reading, problem.limits, ambient_c)
        yield number("{weights}_printed_value", float(values[0]))
        yield number("{weights}_printed_fitness", float(fitness(values)[0]))
        yield number("{weights}_value", float(values[1]))
        yield number("{weights}_time_s", float(rows.time_s[1]))
        yield number("{weights}_largest_increase_a", summary.increase(cases[name]))
        for reading in READINGS:
            yield number("{weights}_{reading}_k", float(rows.rise_k(reading)[1]), reading=reading)
        if place == 0:
            best = best_weighted(problem, pair, starts)
            yield number("{weights}_best_value", best.value)
            yield number("{weights}_agreeing_share", best.agreeing)


def _kept(problem: Problem, cases: Mapping[str, Array]) -> Iterator[Quantity]:
    for reading, (time_s, share) in _gains(problem, cases).items():
        yield SEARCHED.quantity("same_{reading}_s", time_s, reading=reading)
        yield SEARCHED.quantity("same_{reading}_share", share, reading=reading)


def _front(problem: Problem, cases: Mapping[str, Array], evolved: Array) -> Iterator[Quantity]:
    """Yield the numbers of the front: a point is a calibration of its own, so that the least of all is its gain."""
    for kept, (_, share) in _gains(problem, cases).items():
        yield FRONT.quantity("{end}_same_{kept}_share", share, end="least", kept=kept)
    printed, others = charge(problem.grid, cases[summary.PRINTED][None, :]), charge(problem.grid, evolved)
    faster = others.time_s < printed.time_s[0]
    better = faster & (others.rise_k("peak") < printed.rise_k("peak")[0])
    yield FRONT.quantity("{kept}_dominating_points", float(np.sum(better)), kept="peak")


def _gains(problem: Problem, cases: Mapping[str, Array]) -> dict[str, tuple[float, float]]:
    """Return the shortest time with no more than the printed rise, and the share it saves, for each that is kept."""
    printed = cases[summary.PRINTED]
    shown = charge(problem.grid, printed[None, :])
    found = {}
    for kept in KEPT:
        span, rise = problem.currents, float(shown.rise_k(kept)[0])
        asked = problem._replace(reading=kept)
        starts = np.clip(np.array([cases[f"same_{kept}"], printed]), span.low, span.high)
        try:
            time_s = fastest(asked, rise, starts[:1]).value
        except ValueError:  # the study's own optimum is too far from this point's
            time_s = fastest(asked, rise, starts).value
        found[str(kept)] = (time_s, 1.0 - time_s / float(shown.time_s[0]))
    return found
