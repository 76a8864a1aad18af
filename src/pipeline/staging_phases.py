"""The nodes of a search for the currents of a staged charge: each search, what they come to, the front."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.config.staged import plan_of, searches
from pipeline.config.study import Study
from pipeline.draft import Draft, plain
from pipeline.objective.staging_records import Staging, Weights
from pipeline.search import registry

_SEARCH_FILES = ("runs", "run_currents", "course")


def staging(study: Study) -> Iterator[Draft]:
    """Yield the nodes of a study that searches for stage currents, in the order in which they read each other."""
    if study.staging is None:
        return
    made = list(_searches(study, study.staging))
    yield from made
    yield _cases(study, study.staging, made)
    yield _front(study, study.staging)


def used_settings(study: Study) -> dict[str, Any]:
    """Return the settings of the search whose currents are charged with; nothing for a study without one."""
    if study.staging is None:
        return {}
    found = searches(study.staging, len(plan_of(study).currents_a))[study.staging.use]
    return dict(plain(found.model_copy(update={"variables": {}})))


def _searches(study: Study, asked: Staging) -> Iterator[Draft]:
    """Every search with the first weights, the one that is used with all of them."""
    known = searches(asked, len(plan_of(study).currents_a))
    for place, (weights, pair) in enumerate(asked.weights.items()):
        for name, settings in known.items():
            if place > 0 and name != asked.use:
                continue
            yield Draft(
                "staging_search",
                f"staging_search/{weights}/{name}",
                f"{weights}.{name}",
                plain(
                    {
                        "problem": _problem(study, asked, pair),
                        "search": settings.model_copy(update={"title": "search"}),
                        "evaluations": asked.evaluations,
                        "seed": study.seed,
                    }
                ),
                sections=_sections(study),
                shown={f"{part}.parquet": f"staging/{weights}/{name}.{part}.parquet" for part in _SEARCH_FILES},
                modules=(registry.module_name(settings.kind),),
            )


def _cases(study: Study, asked: Staging, made: list[Draft]) -> Draft:
    first = next(iter(asked.weights))
    runs = {node.name: node.name for node in made}
    return Draft(
        "staging",
        "staging",
        study.study.name,
        plain(
            {
                "problem": _problem(study, asked, asked.weights[first]),
                "weights": [{"name": name, **plain(pair)} for name, pair in asked.weights.items()],
                "searches": list(asked.searches),
                "use": asked.use,
                "evaluations": asked.evaluations,
                "starts": asked.starts,
                "chords": asked.chords,
                "seed": study.seed,
            }
        ),
        inputs=runs,
        sections=_sections(study),
        shown={f"{part}.parquet": f"staging/{part}.parquet" for part in ("cases", "currents", "quantities")},
    )


def _front(study: Study, asked: Staging) -> Draft:
    calibrations = [{"name": name, "battery": _nameless(battery)} for name, battery in study.calibrations.items()]
    first = next(iter(asked.weights.values()))
    return Draft(
        "front",
        "front",
        study.study.name,
        plain(
            {
                "problem": _problem(study, asked, first),
                "calibrations": calibrations,
                "front": asked.front,
                "starts": asked.starts,
                "seed": study.seed,
            }
        ),
        sections=(*_sections(study), *(f"calibrations.{name}" for name in study.calibrations)),
        shown={
            f"{part}.parquet": f"front/{part}.parquet"
            for part in ("front", "calibrations", "calibration_stages", "quantities")
        },
    )


def _problem(study: Study, asked: Staging, weights: Weights) -> dict[str, Any]:
    return {
        "battery": _nameless(study.battery),
        "plan": plain(plan_of(study)),
        "current_a": plain(asked.current_a),
        "rise": asked.rise,
        "weights": plain(weights),
    }


def _nameless(battery: Any) -> dict[str, Any]:
    """Return a battery with its name for a title: titles are for readers, and changing one must compute nothing."""
    return {**plain(battery), "title": battery.name}


def _sections(study: Study) -> tuple[str, ...]:
    assert study.staging is not None
    return ("staging", "battery", f"modes.{study.staging.mode}", "charge")
