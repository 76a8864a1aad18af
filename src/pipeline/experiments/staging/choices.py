"""What a search for stage currents takes from the rest of a study, and what the rest may ask of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from pipeline.charge.protocol import Resolver, parameters
from pipeline.charge.waveforms import Staged
from pipeline.errors import UserError, best_matches
from pipeline.experiments.staging.records import KEPT, READINGS, Plan
from pipeline.record import Reference
from pipeline.search.box import SearchSettings
from pipeline.search.registry import settings_from

STAGES_NAMED = 8
"""Stages that statements may speak of although a run has fewer."""
WARMEST_C = 100.0
"""Limit of the temperature for a mode whose stop gives none [degC]."""
LISTS = ("found_currents_a", "same_peak_currents_a", "same_final_currents_a")
"""Lists of currents that are found, one for each stage [A]."""
CONSTANTS = ("constant_same_time_a", "constant_same_peak_a", "constant_same_final_a")
"""Constant currents that are found [A]."""
_LEFT_OUT = ("side_reaction", "acceptance", "charge_transfer")


def plan_of(study: Any) -> Plan:
    """Return the stages of the mode that the search is for.

    Raises
    ------
    UserError : no such mode, or one without stages, with currents still to be found, or without a voltage limit.
    """
    name = study.staging.mode
    if name not in study.modes:
        raise UserError(f"staging.mode: no mode {name!r} among those of this study; {best_matches(name, study.modes)}")
    mode = study.modes[name]
    resolver = Resolver(mode, study.battery.capacity_in_use_ah, study.battery.cells)
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


def search_of(staging: Any, name: str, stages: int) -> SearchSettings:
    """Return the settings of a search with the box that all of them share.

    Arguments
    ---------
    staging : the record of the study, or what may be read of it.
    name : of the search.
    stages : how many currents are searched for.

    Raises
    ------
    UserError : settings that their algorithm refuses.
    """
    edges = {"low": staging.current_a.low, "high": staging.current_a.high}
    box = {f"current_{n}_a": edges for n in range(1, stages + 1)}
    values = {"replicates": staging.replicates, **staging.searches[name], "title": name, "variables": box}
    try:
        found: SearchSettings = settings_from(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join([f"staging.searches.{name}", *(str(part) for part in first["loc"])])
        raise UserError(f"{key}: {first['msg'].removeprefix('Value error, ')} (value {first['input']!r})") from None
    except ValueError as error:
        raise UserError(f"staging.searches.{name}.{error}") from None
    return found


def check(study: Any) -> None:
    """Check that the stages can be searched for, and that what charges with the currents has a stage for each.

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
    batteries = {f"calibrations.{name}": battery for name, battery in study.calibrations.items()}
    for path, battery in {"battery": study.battery, **batteries}.items():
        for part in _LEFT_OUT:
            if getattr(battery, part) is not None:
                raise UserError(
                    f"{path}.{part}: stage currents are searched for batteries of resistances and pairs alone; "
                    "take another battery, or leave staging out"
                )
        if any(warmth is not None for warmth in battery.warmths):
            raise UserError(
                f"{path}.series_resistance_temperature: stage currents are searched for resistances that do not depend "
                "on temperature; take another battery, or leave staging out"
            )
    if study.charge.start_c != study.charge.ambient_c:
        raise UserError(
            f"charge.initial_temperature_c: {study.charge.start_c:g} degC; stage currents are searched for a battery "
            f"that begins at the ambient's {study.charge.ambient_c:g}; leave it out, or leave staging out"
        )
    stages = len(plan.currents_a)
    for name in staging.searches:
        search_of(staging, name, stages)
    for path, edges in _charged_with(study):
        if len(edges) != stages:
            raise UserError(
                f"{path}: {len(edges)} edges, but the stages of {staging.mode!r}, whose currents are found, "
                f"are {stages}; give one each"
            )


def _charged_with(study: Any) -> Iterator[tuple[str, list[float]]]:
    """Yield the key path and the edges of SOC of every phase that takes a list of currents from the search."""
    for name, mode in study.modes.items():
        for title, phase in mode.phases.items():
            waveform = phase.waveform
            if not isinstance(waveform, Staged) or not isinstance(waveform.currents_a, Reference):
                continue
            if waveform.currents_a.source == "staging":
                yield f"modes.{name}.phases.{title}.staged.soc_edges", waveform.soc_edges


def finds(study: Any) -> dict[str, tuple[str, ...]]:
    """Return the names of the values that the search finds for others."""
    return {} if study.staging is None else {"staging": (*LISTS, *CONSTANTS)}


def fields(study: Any) -> dict[str, Mapping[str, Iterable[object]]]:
    """Return what the fields in the names of the numbers stand for; nothing for a study without a search."""
    staging = study.staging
    if staging is None:
        return {}
    # Statements on stages that a run does not have are not checkable, which is no mistake in them.
    stages = max(len(plan_of(study).currents_a), STAGES_NAMED)
    return {
        "staging": {
            "reading": READINGS,
            "kept": KEPT,
            "stage": range(1, stages + 1),
            "weights": staging.weights,
            "search": staging.searches,
            "use": [staging.use],
            "other": [name for name in staging.searches if name != staging.use],
        },
        "front": {"kept": KEPT, "end": ("least", "most"), "calibration": study.calibrations},
    }
