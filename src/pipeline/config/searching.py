"""What a study's search and tuning take from the rest of it, and what the rest may ask of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from pipeline.charge.protocol import Resolver, parameters
from pipeline.charge.records import Mode
from pipeline.config import staged
from pipeline.errors import UserError, best_matches
from pipeline.grnn.records import LONG
from pipeline.objective.records import Waveform
from pipeline.record import Reference
from pipeline.search.box import SearchSettings

if TYPE_CHECKING:
    from pipeline.config.study import Study

VARIABLE = "frequency_hz"
KNOBS = ("c1", "c2", "w")
TUNED = "swarm"
"""The algorithm whose knobs a design can tune."""


def check(study: Study) -> None:
    """Check that the search has what it needs, and that every found value that is asked for can be found.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    if study.objective is not None:
        _check_objective(study)
    if study.search is not None:
        if study.objective is None or study.oracle is None:
            raise UserError("search: a study with a search needs an objective, and a sweep as its oracle")
        for name, settings in (("search", study.search), ("oracle", study.oracle)):
            if list(settings.variables) != [VARIABLE]:
                raise UserError(f"{name}.variables: are {list(settings.variables)}; the objective has one, {VARIABLE}")
    if study.oracle is not None and study.oracle.kind != "sweep":
        raise UserError(f"oracle.kind: {study.oracle.kind!r}; the other searches are held against a sweep alone")
    if study.design is not None:
        for name in study.design.factors:
            if name not in KNOBS:
                raise UserError(f"design.factors.{name}: no knob of the swarm; {best_matches(name, KNOBS)}")
    found = found_values(study)
    for path, reference in _references(study):
        _check_reference(path, reference, found)


def found_values(study: Study) -> dict[str, tuple[str, ...]]:
    """Return step -> names of the values it finds, for the steps the study has."""
    found: dict[str, tuple[str, ...]] = {}
    if study.search is not None:
        found["search"] = tuple(study.search.variables)
        if study.design is not None and study.search.kind == TUNED:
            found["tuning"] = tuple(study.design.factors)
    if study.network is not None:
        found["network"] = (*study.network.selection.methods, LONG)
    if study.staging is not None:
        found["staging"] = staged.found_names(study)
    return found


def searches(study: Study) -> dict[str, SearchSettings]:
    """Return the searches that are run, by name: the one whose result is used, its variants, the sweep."""
    if study.search is None:
        return {}
    own = study.search
    found = {own.kind: own} | {name: own.variant(name) for name in own.variants}
    return found | ({study.oracle.kind: study.oracle} if study.oracle is not None else {})


def waveform(mode: Mode, capacity_ah: float) -> Waveform | None:
    """Return the currents and shares of a mode's first phase of pulses; none where it has none, or they are open.

    Arguments
    ---------
    capacity_ah : capacity of the battery in use, for currents given as C-rates [A h].
    """
    for name, phase in mode.phases.items():
        if not phase.waveform.periodic:
            continue
        values = parameters(Resolver(mode, capacity_ah), phase.waveform, f"phases.{name}")
        own = {key: value for key, value in values.items() if key in Waveform.model_fields}
        if any(isinstance(value, Reference) for value in own.values()):
            return None
        return Waveform.model_validate(own)
    return None


def pulsed_modes(study: Study) -> dict[str, Waveform]:
    """Return the waveform of every mode with pulses."""
    found = {name: waveform(mode, study.battery.capacity_in_use_ah) for name, mode in study.modes.items()}
    return {name: one for name, one in found.items() if one is not None}


def _check_objective(study: Study) -> None:
    assert study.objective is not None
    name = study.objective.mode
    if name not in study.modes:
        raise UserError(f"objective.mode: no mode {name!r}; {best_matches(name, study.modes)}")
    try:
        found = waveform(study.modes[name], study.battery.capacity_in_use_ah)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise UserError(f"modes.{name}: {first['msg'].removeprefix('Value error, ')}") from None
    if found is None:
        raise UserError(
            f"objective.mode: {name!r} has no pulses with currents and shares that are numbers, to search a rate for"
        )


def _references(study: Study) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield key path and content of every reference in the modes and the search.

    The objective's mode comes first: others may have theirs from it.
    """
    first = None if study.objective is None else study.objective.mode
    modes = sorted(study.modes, key=lambda name: name != first)
    sections = (*(f"modes.{name}" for name in modes), "search")
    for section in sections:
        for path, value in study.parameters(section):
            if isinstance(value, Mapping):
                yield path, value


def _check_reference(path: str, reference: Mapping[str, Any], found: Mapping[str, tuple[str, ...]]) -> None:
    step, value = str(reference["from"]), str(reference["value"])
    if path.startswith("search.") and step == "search":
        raise UserError(f"{path}.from: 'search' would wait for itself; allowed is tuning, or a number")
    if step not in found:
        raise UserError(f"{path}.from: no step {step!r} finds values in this study; {best_matches(step, found)}")
    if value not in found[step]:
        raise UserError(f"{path}.value: {step} finds no {value!r}; {best_matches(value, found[step])}")
