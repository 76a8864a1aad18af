"""The search for the currents of a staged charge: each search, what they come to, the front of time and rise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from pydantic import Field

from pipeline.cell.records import Battery
from pipeline.experiments.staging.choices import check, fields, finds, plan_of, search_of
from pipeline.experiments.staging.records import Staging
from pipeline.experiments.staging.tables import GATHERED, SEARCH, TRADED
from pipeline.experiments.staging.vocabulary import FRONT, SEARCHED
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import CHAOTIC
from pipeline.published.ensemble import ANSWERS, NAME, asked, estimates
from pipeline.record import Record
from pipeline.search import registry
from pipeline.search.box import evaluations, kept_b


class StagingPart(Record):
    """The search for stage currents, and other calibrations of the battery that it is held against."""

    staging: Staging | None = Field(default=None, description="search for the currents of a staged charge")
    calibrations: dict[str, Battery] = Field(default_factory=dict, description="batteries it is repeated on, by name")


def _search_settings(config: Any, weights: str, search: str, **_: Any) -> dict[str, Any]:
    stages = len(plan_of(config).currents_a)
    return {
        "problem": _problem(config, weights),
        "search": search_of(config.staging, search, stages).model_copy(update={"title": "search"}),
        "evaluations": config.staging.evaluations,
        "seed": config.seed,
    }


def _gathered_settings(config: Any, first: str, **_: Any) -> dict[str, Any]:
    staging = config.staging
    return {
        "problem": _problem(config, first),
        "weights": [{"name": name, **plain(pair)} for name, pair in staging.weights.items()],
        "searches": list(staging.searches),
        "use": staging.use,
        "evaluations": staging.evaluations,
        "starts": staging.starts,
        "chords": staging.chords,
        "seed": config.seed,
    }


def _front_settings(config: Any, weights: str, **_: Any) -> dict[str, Any]:
    batteries = config.calibrations.items()
    return {
        "problem": _problem(config, weights),
        "calibrations": [{"name": name, "battery": untitled(battery, battery.name)} for name, battery in batteries],
        "front": config.staging.front,
        "starts": config.staging.starts,
        "seed": config.seed,
    }


def _stage_ensemble(config: Any, first: str, estimated: Mapping[str, Any], **_: Any) -> dict[str, Any]:
    return {
        "problem": _problem(config, first),
        "weights": [{"name": name, **plain(pair)} for name, pair in config.staging.weights.items()],
        "front": config.staging.front,
        "points": config.ensemble.slow_points,
        "estimated": estimated,
        "seed": config.seed,
        "asked": asked(config, ("staging", "front")),
    }


def _seed_ensemble(config: Any, first: str, compared: list[str], **_: Any) -> dict[str, Any]:
    stages = len(plan_of(config).currents_a)
    listed = {name: search_of(config.staging, name, stages) for name in compared}
    return {
        "problem": _problem(config, first),
        "first": first,
        "searches": [
            {"name": name, "settings": found.model_copy(update={"title": "search"})} for name, found in listed.items()
        ],
        "use": config.staging.use,
        "evaluations": config.staging.evaluations,
        "experiments": config.ensemble.experiments,
        "seed": config.seed,
        "asked": asked(config, ("staging",), "search"),
    }


def _problem(config: Any, weights: str) -> dict[str, Any]:
    return {
        "battery": untitled(config.battery, config.battery.name),
        "plan": plan_of(config),
        "current_a": config.staging.current_a,
        "rise": config.staging.rise,
        "weights": config.staging.weights[weights],
    }


_PROBLEM = (
    *("battery", "modes.{mode}", "charge.initial_soc", "charge.ambient_c"),
    *("staging.mode", "staging.current_a", "staging.rise", "seed"),
)
_CHARGE_S = 5e-6
_COUNTS = ("searches", "replicates", "evaluations")


def _search_effort(config: Any, weights: str, search: str, **_: Any) -> Effort:
    chosen, stages = config.staging, len(plan_of(config).currents_a)
    own = {"replicates": chosen.replicates, **chosen.searches[search]}
    paths = (f"staging.searches.{search}", *(f"staging.{name}" for name in _COUNTS))
    return Effort(kept_b(own, stages), _CHARGE_S * stages * evaluations(own), paths)


def _gathering_effort(config: Any, **_: Any) -> Effort:
    chosen, stages = config.staging, len(plan_of(config).currents_a)
    charges = 3.0 * chosen.chords + 5000.0 * chosen.starts * len(chosen.weights)
    memory_b = 8.0 * stages * (8.0 * chosen.chords + 100.0 * chosen.starts)
    return Effort(memory_b, _CHARGE_S * stages * charges, ("staging.chords", "staging.starts"))


def _front_effort(config: Any, **_: Any) -> Effort:
    chosen, stages = config.staging, len(plan_of(config).currents_a)
    charges = chosen.front.population * chosen.front.generations + 5000.0 * chosen.starts * chosen.front.weights
    batteries = 1.0 + len(config.calibrations)
    paths = ("staging.front.generations", "staging.front.population", "staging.front.weights", "staging.starts")
    # Sorting a generation into fronts compares each of its charges with each other.
    memory_b = 80.0 * chosen.front.population**2 + 8.0 * stages * chosen.front.population * 40.0
    sorting_s = 1e-8 * chosen.front.population**2 * chosen.front.generations
    return Effort(memory_b, batteries * (_CHARGE_S * stages * charges + sorting_s), paths)


SEARCH_STEP = Step(
    "staging_search",
    rule="search_stage_currents",
    message="Staging: searches for stage currents, with all replicates: {chunk}",
    settings=_search_settings,
    effort=Footprint(_search_effort, node_s=3.0),
    reads=(
        *_PROBLEM,
        *("staging.weights.{weights}", "staging.searches.{search}", "staging.replicates", "staging.evaluations"),
    ),
    tables=SEARCH,
    target="staging",
    chunk=(3, 3),
    needed_by_figures=True,
)
GATHER_STEP = Step(
    "staging",
    rule="gather_stage_currents",
    message="Staging: the best currents, and the searches against them: {chunk}",
    settings=_gathered_settings,
    effort=Footprint(_gathering_effort, node_s=1.0),
    reads=(
        *_PROBLEM,
        *("staging.weights", "staging.searches", "staging.use"),
        *("staging.evaluations", "staging.starts", "staging.chords"),
    ),
    takes=("staging_search",),
    tables=GATHERED,
    quantities=SEARCHED,
    target="staging",
    chunk=(1, 8),
    finds=True,
    needed_by_figures=True,
)
FRONT_STEP = Step(
    "front",
    rule="trade_time_for_rise",
    message="Front: charging time against temperature rise, under each calibration: {chunk}",
    settings=_front_settings,
    effort=_front_effort,
    reads=(*_PROBLEM, "staging.weights.{weights}", "staging.front", "staging.starts", "calibrations"),
    tables=TRADED,
    quantities=FRONT,
    target="staging",
    chunk=(1, 8),
    needed_by_figures=True,
)


# Ends of searches, as the front is.
_ENDS = {name: replace(file, elsewhere={"value": CHAOTIC}) for name, file in ANSWERS.items()}
STAGE_ENSEMBLE = Step(
    "stage_ensemble",
    rule="stage_over_estimates",
    message="Staged charges over the ranges of estimated parameters: {chunk}",
    effort=Footprint(node_s=12.0),
    settings=_stage_ensemble,
    reads=(*_PROBLEM, "staging.weights", "staging.front", "ensemble", "published", "answer"),
    takes=("staging",),
    tables=_ENDS,
    priority=1,
    shown=False,
)
SEED_ENSEMBLE = Step(
    "seed_ensemble",
    rule="search_stages_with_other_seeds",
    message="Searches for stage currents with other seeds: {chunk}",
    effort=Footprint(node_s=8.0),
    settings=_seed_ensemble,
    reads=(
        *_PROBLEM,
        *("staging.weights.{first}", "staging.searches", "staging.use", "staging.replicates", "staging.evaluations"),
        *("ensemble", "published", "answer"),
    ),
    takes=("staging",),
    tables=_ENDS,
    priority=1,
    shown=False,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield every search with the first weights, the one that is used with all; what they come to; the front."""
    if study.staging is None:
        return
    staging = study.staging
    first, mode = next(iter(staging.weights)), staging.mode
    made = [
        _search(mode, weights, name, staging.searches[name]["kind"])
        for weights in staging.weights
        for name in staging.searches
        if weights == first or name == staging.use
    ]
    yield from made
    own = study.study.name
    runs = {node.name: node.name for node in made}
    which = {"mode": mode, "first": first}
    yield Node(GATHER_STEP, "staging", own, which, inputs=runs, shown=GATHER_STEP.places("staging"))
    which = {"mode": mode, "weights": first}
    yield Node(FRONT_STEP, "front", own, which, shown=FRONT_STEP.places("front"))
    which = {"mode": mode, "first": first}
    yield from _ensembles(study, which, tuple(registry.module_name(one["kind"]) for one in staging.searches.values()))


def _ensembles(study: Any, which: Mapping[str, Any], modules: tuple[str, ...]) -> Iterator[Node]:
    """Yield the charges over the ranges of the estimated parameters, and the searches with other seeds."""
    own, given = study.study.name, {"staging": "staging"}
    estimated = estimates(study.sources, ("battery", "staging.current_a"))
    if study.ensemble.slow_points and estimated["ranges"] and asked(study, ("staging", "front")):
        shown = {"ensemble.parquet": "published/ensemble_of_stages.parquet"}
        yield Node(STAGE_ENSEMBLE, f"{NAME}/staging", own, {**which, "estimated": estimated}, given, shown)
    read = " ".join(str(value["quantity"]) for value in asked(study, ("staging",), "search"))
    compared = [name for name in study.staging.searches if name in read or name == study.staging.use]
    if study.ensemble.experiments and read:
        shown = {"ensemble.parquet": "published/ensemble_of_stage_searches.parquet"}
        which = {**which, "compared": compared}
        yield Node(SEED_ENSEMBLE, f"{NAME}/staging_search", own, which, given, shown, modules=modules)


def _search(mode: str, weights: str, search: str, kind: str) -> Node:
    return Node(
        SEARCH_STEP,
        f"staging_search/{weights}/{search}",
        f"{weights}.{search}",
        {"mode": mode, "weights": weights, "search": search},
        shown={one.file: f"staging/{weights}/{search}.{one.file}" for one in SEARCH.values()},
        modules=(registry.module_name(kind),),
    )


def _used(config: Any) -> dict[str, Any]:
    """Return the settings of the search whose currents are charged with, without its box; nothing without one."""
    staging = config.staging
    if staging is None:
        return {}
    return dict(plain(search_of(staging, staging.use, 1).model_copy(update={"variables": {}})))


EXPERIMENT = Experiment(
    title="the currents of a staged charge, searched for",
    steps=(SEARCH_STEP, GATHER_STEP, FRONT_STEP, STAGE_ENSEMBLE, SEED_ENSEMBLE),
    nodes=nodes,
    part=StagingPart,
    parameters=("staging", "calibrations.*"),
    refers={"staging.mode": "modes"},
    checks=(check,),
    finds=finds,
    inputs=lambda study: ("staging", "front") if study.staging is not None else (),
    fields=fields,
    labels={
        "stage_search": Label(_used, ("staging.use", "staging.searches", "staging.replicates", "staging.current_a"))
    },
)
