"""What a study searches a frequency for and with, and whether it goes together."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import Field, ValidationError

from pipeline.cell.records import value_of
from pipeline.charge.protocol import Resolver, parameters
from pipeline.charge.records import Mode
from pipeline.errors import UserError, best_matches
from pipeline.experiments.frequency.outcome import VARIABLE
from pipeline.experiments.frequency.tuning_tables import KNOBS
from pipeline.objective.records import ReflexFrequency, Waveform
from pipeline.published.reference import reference_tables
from pipeline.record import Record, Reference
from pipeline.search.box import ChaosSettings, SearchSettings
from pipeline.search.registry import AnySettings
from pipeline.taguchi.arrays import Design

TUNED = "swarm"
"""The algorithm whose knobs a design can tune."""


class FrequencyPart(Record):
    """What is minimised, and how it is searched."""

    chaos: ChaosSettings | None = None
    objective: ReflexFrequency | None = Field(default=None, description="what a search minimises")
    design: Design | None = Field(default=None, description="parameter design that tunes the search")
    search: AnySettings | None = Field(default=None, description="the search whose result others may ask for")
    oracle: AnySettings | None = Field(default=None, description="the sweep it is compared with")


def check(study: Any) -> None:
    """Refuse an objective, a search or a design that lacks something.

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
        raise UserError(f"oracle.kind: {study.oracle.kind!r}; the other searches are compared with a sweep alone")
    if study.design is not None:
        _check_design(study.design)


def finds(study: Any) -> dict[str, tuple[str, ...]]:
    """Return step -> names of the values it finds, for the steps the study has."""
    if study.search is None:
        return {}
    found = {"search": tuple(study.search.variables)}
    if study.design is not None and study.search.kind == TUNED:
        found["tuning"] = tuple(study.design.factors)
    return found


def searches(config: Any) -> dict[str, SearchSettings]:
    """Return the searches that are run, by name: the one whose result is used, its variants, the sweep."""
    if config.search is None:
        return {}
    own = config.search
    found = {own.kind: own} | {name: own.variant(name) for name in own.variants}
    return found | ({config.oracle.kind: config.oracle} if config.oracle is not None else {})


def waveform(mode: Mode, capacity_in_use_ah: float) -> Waveform | None:
    """Return the currents and shares of a mode's first phase of pulses; none where it has none, or they are open.

    Arguments
    ---------
    capacity_in_use_ah : of the battery, for currents given as C-rates [A h].
    """
    for name, phase in mode.phases.items():
        if not phase.waveform.periodic:
            continue
        values = parameters(Resolver(mode, capacity_in_use_ah), phase.waveform, f"phases.{name}")
        own = {key: value for key, value in values.items() if key in Waveform.model_fields}
        if any(isinstance(value, Reference) for value in own.values()):
            return None
        return Waveform.model_validate(own)
    return None


def pulsed_modes(config: Any, names: Iterable[str]) -> dict[str, Waveform]:
    """Return the waveform of those of some modes that have pulses."""
    found = {name: waveform(config.modes[name], config.battery.capacity_in_use_ah) for name in names}
    return {name: one for name, one in found.items() if one is not None}


def whole_battery(config: Any) -> float:
    """Return what a resistance of one cell is multiplied by for the whole battery: in series, and scaled [1]."""
    return float(config.battery.cells_in_series / config.battery.scale)


def pairs(config: Any) -> list[list[float]]:
    """Return resistances [ohm] and time constants [s] of the whole battery's pairs at the objective's SOC."""
    factor, soc, found = whole_battery(config), config.objective.soc, list(config.battery.pairs.values())
    return [[factor * value_of(one.resistance_ohm, soc) for one in found], [one.time_constant_s for one in found]]


def objective_settings(config: Any, modes: Iterable[str], **_: Any) -> dict[str, Any]:
    """Return what the step `objective` is given, for the waveforms of some modes."""
    resistance = value_of(config.battery.series_resistance_ohm, config.objective.soc)
    return {
        # Titles are for readers, and changing one must compute nothing.
        "objective": config.objective.model_copy(update={"title": config.objective.kind}),
        "waveforms": pulsed_modes(config, modes),
        "pairs": pairs(config),
        "series_resistance_ohm": whole_battery(config) * resistance,
        "thermal_resistance_k_w": config.battery.thermal.resistance_k_w,
    }


def problem(config: Any) -> dict[str, Any]:
    """Return all that the integral square error depends on, as `objective.records.Problem` has it."""
    objective = config.objective
    return {
        "waveform": pulsed_modes(config, [objective.mode])[objective.mode],
        "pairs": pairs(config),
        "transistor": objective.transistor,
        "window_s": objective.window_s,
    }


def _check_objective(study: Any) -> None:
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


def _check_design(design: Design) -> None:
    for name in design.factors:
        if name not in KNOBS:
            raise UserError(f"design.factors.{name}: no knob of the swarm; {best_matches(name, KNOBS)}")
    tables = {path.stem for path in reference_tables()}
    if design.printed is not None and design.printed not in tables:
        raise UserError(f"design.printed: no table {design.printed!r}; {best_matches(design.printed, tables)}")
