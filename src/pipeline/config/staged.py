"""What a search for stage currents takes from the rest of a study, and what the rest may ask of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ValidationError

from pipeline.charge.protocol import Resolver, parameters
from pipeline.charge.waveforms import Staged
from pipeline.errors import UserError, best_matches
from pipeline.objective.staging_names import front_quantities, search_quantities
from pipeline.objective.staging_records import Plan, Staging
from pipeline.record import Reference
from pipeline.search.box import SearchSettings
from pipeline.search.registry import settings_from

if TYPE_CHECKING:
    from pipeline.config.study import Study

STAGES_NAMED = 8
"""Stages that statements may speak of although a run has fewer."""
WARMEST_C = 100.0
"""Limit of the temperature for a mode whose stop gives none [degC]."""


def plan_of(study: Study) -> Plan:
    """Return the stages of the mode that the search is for.

    Raises
    ------
    UserError : no such mode, or one without stages, with currents still to be found, or without a voltage limit.
    """
    assert study.staging is not None
    name = study.staging.mode
    if name not in study.modes:
        raise UserError(f"staging.mode: no mode {name!r} among those of this study; {best_matches(name, study.modes)}")
    mode = study.modes[name]
    resolver = Resolver(mode, study.battery.capacity_in_use_ah)
    for title, phase in mode.phases.items():
        waveform = phase.waveform
        if not isinstance(waveform, Staged):
            continue
        where = f"phases.{title}"
        values = parameters(resolver, waveform, where)
        limit = resolver.optional(phase.limit, f"{where}.limit").get("voltage_v")
        stop = resolver.optional(mode.stop, "stop").get("temperature_c", WARMEST_C)
        currents = [value for key, value in values.items() if key.split(".")[0] == "currents_a"]
        if any(isinstance(value, Reference) for value in (*currents, limit, stop)):
            raise UserError(f"staging.mode: {name!r} has values that are still to be found; numbers are needed")
        if limit is None:
            raise UserError(f"staging.mode: {name!r} has no limit.voltage_v, which the currents must keep to")
        return Plan(
            currents_a=currents,
            soc_edges=[study.charge.initial_soc, *waveform.soc_edges],
            voltage_v=limit,
            temperature_c=stop,
            ambient_c=study.charge.ambient_c,
        )
    raise UserError(f"staging.mode: {name!r} has no staged phase")


def searches(staging: Staging, stages: int) -> dict[str, SearchSettings]:
    """Return the searches with the box they share, by name.

    Raises
    ------
    UserError : settings that their algorithm refuses.
    """
    edges = {"low": staging.current_a.low, "high": staging.current_a.high}
    box = {f"current_{n}_a": edges for n in range(1, stages + 1)}
    found: dict[str, SearchSettings] = {}
    for name, own in staging.searches.items():
        values = {"replicates": staging.replicates, **own, "title": name, "variables": box}
        try:
            found[name] = settings_from(values)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            key = ".".join([f"staging.searches.{name}", *(str(part) for part in first["loc"])])
            raise UserError(f"{key}: {first['msg'].removeprefix('Value error, ')} (value {first['input']!r})") from None
        except ValueError as error:
            raise UserError(f"staging.searches.{name}.{error}") from None
    return found


def check(study: Study) -> None:
    """Check that the stages can be searched for.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    staging = study.staging
    if staging is None:
        if study.calibrations:
            raise UserError("calibrations: a study without staging has no use for them")
        return
    plan = plan_of(study)
    if plan.soc_edges[0] >= plan.soc_edges[1]:
        raise UserError(
            f"charge.initial_soc: {plan.soc_edges[0]:g} lies beyond the first stage of {staging.mode!r}, "
            f"which ends at {plan.soc_edges[1]:g}"
        )
    for path, battery in {"battery": study.battery, **_named_calibrations(study)}.items():
        for part in ("side_reaction", "acceptance", "charge_transfer"):
            if getattr(battery, part) is not None:
                raise UserError(
                    f"{path}.{part}: stage currents are searched for batteries of resistances and pairs alone; "
                    "take another battery, or leave staging out"
                )
    searches(staging, len(plan.currents_a))


def _named_calibrations(study: Study) -> dict[str, object]:
    return {f"calibrations.{name}": battery for name, battery in study.calibrations.items()}


def found_names(study: Study) -> tuple[str, ...]:
    """Return the names of the values the search finds for others."""
    stages = len(plan_of(study).currents_a)
    numbered = (f"{of}_{n}_a" for of in ("found", "same_peak", "same_final") for n in range(1, stages + 1))
    return (*numbered, *(f"constant_{what}_a" for what in ("same_time", "same_peak", "same_final")))


def quantities(study: Study) -> dict[str, set[str]]:
    """Return the named numbers that the steps of the search find; nothing for a study without one."""
    staging = study.staging
    if staging is None:
        return {}
    # Statements on stages that a run does not have are not checkable, which is no mistake in them.
    stages = max(len(plan_of(study).currents_a), STAGES_NAMED)
    names = tuple(staging.searches)
    return {
        "staging": search_quantities(stages, tuple(staging.weights), names, staging.use),
        "front": front_quantities(tuple(study.calibrations)),
    }
