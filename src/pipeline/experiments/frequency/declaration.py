"""The frequency of the pulses: the map behind chaos, the objective, the tuning, the search; what others may read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pipeline.config.compose import options
from pipeline.experiments.frequency import choices, outcome, tuning
from pipeline.experiments.frequency.choices import FrequencyPart, pulsed_modes, searches
from pipeline.experiments.frequency.outcome import VARIABLE
from pipeline.experiments.frequency.tables import CHAOS, OBJECTIVE, SEARCH, SETS, TUNING
from pipeline.experiments.frequency.tuning_tables import CHAOS_NUMBERS, OBJECTIVE_NUMBERS
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import Draft, Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.published.ensemble import ANSWERS, NAME, asked, estimates
from pipeline.search import registry
from pipeline.search.box import evaluations, kept_b

# The objective's terms of the battery, which a search does not see otherwise.
_EVALUATION_S = 1e-6
_PAIRS = ("battery.cells_in_series", "battery.pairs", "battery.capacity_ah", "battery.scaled_to_capacity_ah")
_PROBLEM = ("objective.mode", "objective.soc", "objective.transistor", "objective.window_s", "modes.{mode}", *_PAIRS)


def _objective_ensemble(config: Any, modes: Iterable[str], estimated: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "battery": untitled(config.battery, config.battery.name),
        "modes": {name: {**_without_references(plain(config.modes[name])), "title": name} for name in modes},
        "objective": {**plain(config.objective), "title": config.objective.kind},
        "points": config.ensemble.points,
        "estimated": estimated,
        "seed": config.seed,
        "asked": asked(config, ("objective",)),
    }


def _without_references(tree: Any) -> Any:
    """Return a mode with 1 for every value that is found elsewhere: its rate, on which no loss of a period depends."""
    if not isinstance(tree, Mapping):
        return tree
    return 1.0 if set(tree) == {"from", "value"} else {key: _without_references(value) for key, value in tree.items()}


def _search_ensemble(config: Any, tuned: bool, **which: Any) -> dict[str, Any]:
    return {
        "search": _search_settings(config, **which),
        "tuning": _tuning_settings(config, **which) if tuned else None,
        "experiments": config.ensemble.experiments,
        "seed": config.seed,
        "asked": asked(config, ("search", "tuning"), "search"),
    }


def _tuning_settings(config: Any, **_: Any) -> dict[str, Any]:
    # The design sets its factors, each run of it counts its own replicates, and the rest is for readers.
    changes = dict.fromkeys(config.design.factors, 0.0) | {"title": "swarm", "replicates": 1, "variants": {}}
    return {
        "design": config.design.model_copy(update={"title": "design"}),
        "swarm": config.search.model_copy(update=changes),
        "problem": choices.problem(config),
        "seed": config.seed,
    }


def _search_settings(config: Any, **_: Any) -> dict[str, Any]:
    untitled = {"title": "search", "variants": {}}
    listed = [{"name": name, "settings": one.model_copy(update=untitled)} for name, one in searches(config).items()]
    return {"searches": listed, "problem": choices.problem(config), "seed": config.seed}


def _chaos_effort(config: Any) -> Effort:
    chosen = config.chaos
    kept = chosen.orbit_steps + chosen.r_points * (chosen.bifurcation_steps + sum(chosen.bins) / len(chosen.bins))
    steps = chosen.orbit_steps + chosen.r_points * (
        chosen.transient + chosen.bifurcation_steps + chosen.disorder_steps * len(chosen.bins)
    )
    counts = ("bifurcation_steps", "disorder_steps", "transient", "r_points", "orbit_steps", "bins")
    return Effort(40.0 * kept, 2e-8 * steps, tuple(f"chaos.{name}" for name in counts))


def _search_effort(config: Any, **_: Any) -> Effort:
    listed = [plain(one) for one in searches(config).values()]
    counts = [f"{part}.{name}" for part in ("search", "oracle") for name in plain(getattr(config, part))]
    paths = (*counts, "search.variants")
    return Effort(sum(kept_b(one, 1) for one in listed), _EVALUATION_S * sum(map(evaluations, listed)), paths)


def _tuning_effort(config: Any, **_: Any) -> Effort:
    swarm = plain(config.search) | {"replicates": 1}
    levels = math.prod(len(one) for one in config.design.factors.values())
    array = len(config.design.array) if not isinstance(config.design.array, str) else levels
    runs = array * config.design.replicates + levels * config.design.factorial_replicates
    paths = ("design.replicates", "design.factorial_replicates", "search.particles", "search.iterations")
    return Effort(runs * kept_b(swarm, 1), _EVALUATION_S * runs * evaluations(swarm), paths)


CHAOS_STEP = Step(
    "chaos",
    rule="follow_logistic_map",
    message="Chaos: orbits and disorder of the logistic map: {chunk}",
    settings=lambda config: {"chaos": config.chaos},
    effort=_chaos_effort,
    reads=("chaos",),
    tables=CHAOS,
    quantities=CHAOS_NUMBERS,
    target="search",
    chunk=(1, 8),
)
OBJECTIVE_STEP = Step(
    "objective",
    rule="loss_over_frequency",
    message="Objective: loss against frequency: {chunk}",
    effort=Footprint(node_s=1.0),
    settings=choices.objective_settings,
    reads=("objective", "modes.{modes}", *_PAIRS, "battery.series_resistance_ohm", "battery.thermal.resistance_k_w"),
    tables=OBJECTIVE,
    quantities=OBJECTIVE_NUMBERS,
    target="search",
    chunk=(1, 32),
)
TUNING_STEP = Step(
    "tuning",
    rule="tune_search",
    message="Tuning: the parameter design, printed and run anew: {chunk}",
    settings=_tuning_settings,
    effort=_tuning_effort,
    reads=("design", "search", "seed", *_PROBLEM),
    tables=TUNING,
    quantities=tuning.VOCABULARY,
    target="tuning",
    chunk=(1, 4),
    files=("conf/published/reference/*.csv",),
    finds=True,
    on_demand=True,
    needed_by_figures=True,
)
SEARCH_STEP = Step(
    "search",
    rule="search_frequency",
    message="Search: the frequency, with all replicates and variants: {chunk}",
    settings=_search_settings,
    effort=_search_effort,
    reads=("search", "oracle", "seed", *_PROBLEM),
    takes=("tuning",),
    tables=SEARCH,
    quantities=outcome.VOCABULARY,
    target="search",
    chunk=(1, 8),
    finds=True,
    on_demand=True,
    needed_by_figures=True,
)


OBJECTIVE_ENSEMBLE = Step(
    "objective_ensemble",
    rule="loss_over_estimates",
    message="Objective over the ranges of estimated parameters: {chunk}",
    effort=Footprint(node_s=5.0),
    settings=_objective_ensemble,
    reads=("battery", "modes.{modes}", "objective", "ensemble", "seed", "published", "answer"),
    tables=ANSWERS,
    chunk=(1, 8),
    shown=False,
)
SEARCH_ENSEMBLE = Step(
    "search_ensemble",
    rule="search_with_other_seeds",
    message="Searches and parameter design with other seeds: {chunk}",
    effort=Footprint(node_s=10.0),
    settings=_search_ensemble,
    reads=("search", "oracle", "design", "seed", *_PROBLEM, "ensemble", "published", "answer"),
    takes=("tuning",),
    tables=ANSWERS,
    files=("conf/published/reference/*.csv",),
    priority=1,
    on_demand=True,
    shown=False,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the nodes that find a frequency, and those that show how."""
    if study.chaos is not None:
        yield Node(CHAOS_STEP, "chaos", "chaos", shown=CHAOS_STEP.places("chaos"))
    if study.objective is None:
        return
    which = {"modes": tuple(pulsed_modes(study, study.modes))}
    yield Node(OBJECTIVE_STEP, "objective", "objective", which, shown=OBJECTIVE_STEP.places("objective"))
    yield from _over_estimates(study, which["modes"])
    if study.search is None:
        return
    title, which = study.study.name, {"mode": study.objective.mode}
    if "tuning" in choices.finds(study):
        not_made = () if study.design.printed is not None else tuple(SETS["published"])
        yield Node(TUNING_STEP, "tuning", title, which, shown=TUNING_STEP.places("tuning", *not_made))
    run = searches(study)
    modules = tuple(sorted({registry.module_name(one.kind) for one in run.values()}))
    files = [f"{name}.{part}.parquet" for name in run for part in ("history", "best")]
    yield Node(
        SEARCH_STEP,
        "search",
        title,
        which,
        shown={file: f"search/{file}" for file in files} | SEARCH_STEP.places("search"),
        modules=modules,
    )


def _over_estimates(study: Any, pulsed: Iterable[str]) -> Iterator[Node]:
    """Yield the objective over the ranges of the estimated parameters, for the modes that statements name."""
    if not study.ensemble.points:
        return
    read = asked(study, ("objective",))
    named = {one["quantity"] for one in read if "quantity" in one}
    modes = [mode for mode in pulsed if mode == study.objective.mode or any(f"_{mode}_" in name for name in named)]
    estimated = estimates(study.sources, ("battery", "objective", *(f"modes.{mode}" for mode in modes)))
    if read and estimated["ranges"]:
        which = {"modes": modes, "estimated": estimated}
        shown = {"ensemble.parquet": "published/ensemble_of_objective.parquet"}
        yield Node(OBJECTIVE_ENSEMBLE, f"{NAME}/objective", "objective", which, shown=shown)


def closing(study: Any, made: Sequence[Draft]) -> Iterator[Node]:
    """Yield the searches with other seeds, where the run searches."""
    names = {node.name for node in made}
    wanted = study.ensemble.experiments and asked(study, ("search", "tuning"), "search")
    if not wanted or "search" not in names:
        return
    modules = tuple(sorted({registry.module_name(one.kind) for one in searches(study).values()}))
    which = {"mode": study.objective.mode, "tuned": "tuning" in names}
    shown = {"ensemble.parquet": "published/ensemble_of_searches.parquet"}
    yield Node(SEARCH_ENSEMBLE, f"{NAME}/search", study.study.name, which, shown=shown, modules=modules)


def _readable(study: Any) -> Iterable[str]:
    own = [name for name in ("chaos", "objective") if getattr(study, name) is not None]
    return [*own, *choices.finds(study), *(["tuning"] if study.design is not None else [])]


def _fields(study: Any) -> Mapping[str, Mapping[str, Iterable[object]]]:
    named = list(searches(study))
    found: dict[str, Mapping[str, Iterable[object]]] = {
        "chaos": {"bins": () if study.chaos is None else study.chaos.bins},
        "objective": {"mode": options("modes")},
        "tuning": {"of": tuple(SETS), "factor": () if study.design is None else tuple(study.design.factors)},
        "search": {"search": named, "first": named[:1], "other": named[1:]},
    }
    # Statements on the swarm are not checkable under another algorithm, which is no mistake in them.
    if study.search is not None and study.search.kind != choices.TUNED:
        del found["search"]
    return found


def _algorithm(config: Any) -> Mapping[str, Any]:
    return {} if config.search is None else plain(config.search.model_copy(update={"variants": {}}))


def _searched(config: Any) -> Mapping[str, Any]:
    """Return lowest and highest frequency that a search looks at [Hz]; nothing where there is no search."""
    return {} if config.search is None else plain(config.search.variables[VARIABLE])


EXPERIMENT = Experiment(
    title="the frequency of the pulses that costs least, and the search for it",
    steps=(CHAOS_STEP, OBJECTIVE_STEP, TUNING_STEP, SEARCH_STEP, OBJECTIVE_ENSEMBLE, SEARCH_ENSEMBLE),
    nodes=nodes,
    closing=closing,
    part=FrequencyPart,
    parameters=("objective", "design", "search", "oracle"),
    refers={"objective.mode": "modes"},
    checks=(choices.check,),
    finds=choices.finds,
    inputs=_readable,
    fields=_fields,
    labels={
        "algorithm": Label(_algorithm, ("search",)),
        "searched": Label(_searched, ("search.variables",)),
    },
)
