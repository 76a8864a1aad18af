"""The frequency of the pulses: the map behind chaos, the objective, the tuning, the search; what others may read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pipeline.cell.records import value_of
from pipeline.config.compose import options
from pipeline.experiments.frequency import choices, outcome, tuning
from pipeline.experiments.frequency.choices import FrequencyPart, pulsed_modes, searches
from pipeline.experiments.frequency.outcome import VARIABLE
from pipeline.experiments.frequency.tables import CHAOS, OBJECTIVE, SEARCH, SETS, TUNING
from pipeline.experiments.frequency.tuning_tables import CHAOS_NUMBERS, OBJECTIVE_NUMBERS
from pipeline.kernel.draft import plain
from pipeline.kernel.experiment import Experiment, Label, Node, Step
from pipeline.search import registry

# The objective's terms of the battery, which a search does not see otherwise.
_PAIRS = ("battery.cells_in_series", "battery.pairs", "battery.capacity_ah", "battery.scaled_to_capacity_ah")
_PROBLEM = ("objective.mode", "objective.soc", "objective.transistor", "objective.window_s", "modes.{mode}", *_PAIRS)


def _objective_settings(config: Any, modes: Iterable[str]) -> dict[str, Any]:
    resistance = value_of(config.battery.series_resistance_ohm, config.objective.soc)
    return {
        # Titles are for readers, and changing one must compute nothing.
        "objective": config.objective.model_copy(update={"title": config.objective.kind}),
        "waveforms": pulsed_modes(config, modes),
        "pairs": choices.pairs(config),
        "series_resistance_ohm": choices.whole_battery(config) * resistance,
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


CHAOS_STEP = Step(
    "chaos",
    rule="follow_logistic_map",
    message="Chaos: orbits and disorder of the logistic map: {chunk}",
    settings=lambda config: {"chaos": config.chaos},
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
    settings=_objective_settings,
    reads=("objective", "modes.{modes}", *_PAIRS, "battery.series_resistance_ohm"),
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


def nodes(study: Any) -> Iterator[Node]:
    """Yield the nodes that find a frequency, and those that show how."""
    if study.chaos is not None:
        yield Node(CHAOS_STEP, "chaos", "chaos", shown=CHAOS_STEP.places("chaos"))
    if study.objective is None:
        return
    which = {"modes": tuple(pulsed_modes(study, study.modes))}
    yield Node(OBJECTIVE_STEP, "objective", "objective", which, shown=OBJECTIVE_STEP.places("objective"))
    if study.search is None:
        return
    title, which = study.study.name, {"mode": study.objective.mode}
    if "tuning" in choices.finds(study):
        not_made = () if study.design.printed is not None else tuple(SETS["published"])
        yield Node(TUNING_STEP, "tuning", title, which, shown=TUNING_STEP.places("tuning", *not_made))
    run = searches(study)
    files = [f"{name}.{part}.parquet" for name in run for part in ("history", "best")]
    yield Node(
        SEARCH_STEP,
        "search",
        title,
        which,
        shown={file: f"search/{file}" for file in files} | SEARCH_STEP.places("search"),
        modules=tuple(sorted({registry.module_name(one.kind) for one in run.values()})),
    )


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
    steps=(CHAOS_STEP, OBJECTIVE_STEP, TUNING_STEP, SEARCH_STEP),
    nodes=nodes,
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
