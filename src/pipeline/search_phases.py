"""The nodes that find values: the map behind chaos, the objective, the tuning, the search."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.cell.records import value_of
from pipeline.config.searching import found_values, pulsed_modes, searches
from pipeline.config.study import Study
from pipeline.draft import Draft, plain
from pipeline.search import registry

FINDERS = frozenset({"tuning", "search"})
"""Steps that run only where something asks for what they find."""

SECTION_OF = {"design": "tuning", "search": "search", "oracle": "search"}
"""Section of the configuration -> the step without which it is not used."""

_CIRCUIT = (
    "battery.cells_in_series",
    "battery.pairs",
    "battery.series_resistance_ohm",
    "battery.scaled_to_capacity_ah",
)
_SETS = ("rerun", "published")
_PARTS = ("runs", "levels", "sums", "anova")


def finders(study: Study) -> Iterator[Draft]:
    """Yield the nodes of a study that find values, and those that show how."""
    yield from _chaos(study)
    yield from _objective(study)
    yield from _tuning(study)
    yield from _search(study)


def _chaos(study: Study) -> Iterator[Draft]:
    if study.chaos is None:
        return
    files = ("orbit", "bifurcation", "disorder", "quantities")
    yield Draft("chaos", "chaos", "chaos", plain({"chaos": study.chaos}), shown=_shown("chaos", files))


def _objective(study: Study) -> Iterator[Draft]:
    if study.objective is None:
        return
    modes = pulsed_modes(study)
    settings = plain({"objective": study.objective, "waveforms": modes, "pairs": _pairs(study)})
    settings["objective"]["title"] = study.objective.kind
    scale = study.battery.cells_in_series / study.battery.scale
    settings["series_resistance_ohm"] = scale * value_of(study.battery.series_resistance_ohm, study.objective.soc)
    yield Draft(
        "objective",
        "objective",
        "objective",
        settings,
        sections=("objective", *(f"modes.{name}" for name in modes), *_CIRCUIT),
        shown=_shown("objective", ("loss", "map", "contour", "quantities")),
    )


def _tuning(study: Study) -> Iterator[Draft]:
    if study.design is None or study.search is None or "tuning" not in found_values(study):
        return
    # The design sets its factors, each run of it counts its own replicates, and the rest is for readers.
    changes = dict.fromkeys(study.design.factors, 0.0) | {"title": "swarm", "replicates": 1, "variants": {}}
    sets = _SETS if study.design.printed is not None else _SETS[:1]
    files = [f"{name}.{part}" for name in sets for part in _PARTS] + ["factorial", "agreement", "quantities"]
    yield Draft(
        "tuning",
        "tuning",
        study.study.name,
        plain(
            {
                "design": study.design.model_copy(update={"title": "design"}),
                "swarm": study.search.model_copy(update=changes),
                "problem": _problem(study),
                "seed": study.seed,
            }
        ),
        sections=("design", "search", *_problem_sections(study)),
        shown=_shown("tuning", files),
    )


def _search(study: Study) -> Iterator[Draft]:
    if study.objective is None or study.search is None:
        return
    run = searches(study)
    untitled = {"title": "search", "variants": {}}
    listed = [{"name": name, "settings": plain(one.model_copy(update=untitled))} for name, one in run.items()]
    files = [f"{name}.{part}" for name in run for part in ("history", "best")]
    yield Draft(
        "search",
        "search",
        study.study.name,
        {"searches": listed, "problem": _problem(study), "seed": study.seed},
        sections=("search", "oracle", *_problem_sections(study)),
        shown=_shown("search", [*files, "statistics", "comparison", "quantities"]),
        modules=tuple(sorted({registry.module_name(one.kind) for one in run.values()})),
    )


def _pairs(study: Study) -> list[list[float]]:
    """Return resistances [ohm] and time constants [s] of the whole battery's pairs at the objective's SOC."""
    assert study.objective is not None
    soc, battery = study.objective.soc, study.battery
    scale = battery.cells_in_series / battery.scale
    pairs = battery.pairs.values()
    return [[scale * value_of(pair.resistance_ohm, soc) for pair in pairs], [pair.time_constant_s for pair in pairs]]


def _problem(study: Study) -> dict[str, Any]:
    assert study.objective is not None
    return {
        "waveform": plain(pulsed_modes(study)[study.objective.mode]),
        "pairs": _pairs(study),
        "transistor": plain(study.objective.transistor),
        "window_s": study.objective.window_s,
    }


def _problem_sections(study: Study) -> tuple[str, ...]:
    assert study.objective is not None
    return ("objective", f"modes.{study.objective.mode}", *_CIRCUIT)


def _shown(room: str, names: Any) -> dict[str, str]:
    return {f"{name}.parquet": f"{room}/{name}.parquet" for name in names}
