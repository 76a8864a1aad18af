"""The root record of a study: every group of `conf/`, assembled and checked against one another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal

from pydantic import Field, ValidationError, field_validator

from pipeline.cell.records import Battery
from pipeline.charge import checks as charge_checks
from pipeline.charge.ensemble import EnsembleSettings
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.trade_off_records import TradeOff
from pipeline.config import daily, panels, searching, staged, switching
from pipeline.config.compose import Composed, options
from pipeline.config.messages import explain
from pipeline.config.sources import Source, attribute, leaves, split
from pipeline.converter.records import Load, PowerChain
from pipeline.converter.records import check as check_supply
from pipeline.day.records import Day
from pipeline.errors import UserError, best_matches
from pipeline.grnn.records import NetworkStudy
from pipeline.objective.records import ReflexFrequency
from pipeline.objective.staging_records import Staging
from pipeline.panel.records import Panel, PanelCurveSettings
from pipeline.published import checks as published_checks
from pipeline.published.names import found_quantities
from pipeline.published.network_names import network_quantities
from pipeline.published.records import Statement
from pipeline.published.reference import reference_tables
from pipeline.record import Record
from pipeline.report.records import FigureCard
from pipeline.search.function_names import names as function_names
from pipeline.search.function_records import FunctionStudy
from pipeline.search.records import ChaosSettings
from pipeline.search.registry import AnySettings
from pipeline.taguchi.records import Design
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.tracking_records import Tracking
from pipeline.validation.records import Validation
from pipeline.weather.records import Weather

# Targets of the workflow, and folders of results/ that are not studies.
RESERVED = frozenset(
    {
        "all",
        "benchmarks",
        "charges",
        "day",
        "figures",
        "functions",
        "logs",
        "network",
        "panel",
        "plan",
        "receipts",
        "report",
        "search",
        "staging",
        "store",
        "tuning",
    }
)


class StudyCard(Record):
    """What a study is called and which paper it follows."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$", description="name of the study, also of its folders and target")
    title: str
    question: str = Field(description="what the study asks, in a sentence")
    paper: str = Field(description="citation of the paper it follows")
    doi: str = Field(default="", description="the paper's DOI, where it has one")
    apart: bool = Field(default=False, description="made only when its own target is asked for, not by `all`")
    on_request: dict[str, tuple[str, ...]] = Field(
        default_factory=dict, description="target -> overrides of a run that is made only when the target is asked for"
    )

    @field_validator("name")
    @classmethod
    def _free(cls, name: str) -> str:
        if name in RESERVED:
            raise ValueError(f"{name!r} is taken; not allowed are {', '.join(sorted(RESERVED))}")
        return name

    @field_validator("on_request")
    @classmethod
    def _targets_free(cls, on_request: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        for target, overrides in on_request.items():
            if target in RESERVED | set(options("study")) or not target.isidentifier():
                raise ValueError(f"target {target!r} is taken or no plain name; take another")
            if not overrides:
                raise ValueError(f"target {target!r} has no overrides; it would be the study itself")
        return on_request


StopName = Literal["soc", "voltage_v", "current_a", "temperature_c", "voltage_drop_v", "temperature_rate_k_s"]


class Comparison(Record):
    """How modes are made comparable."""

    title: str
    mean_current_of: str | None = Field(
        default=None, description="mode whose constant current every pulsed mode's mean is set to; none: as configured"
    )
    stops: tuple[StopName, ...] | None = Field(
        default=None, description="the stops of the modes that count, beside the time; none: all of them"
    )


class Study(Record):
    """A whole study. Parts that a study does without stay empty."""

    study: StudyCard
    seed: int = Field(ge=0, description="root of every random stream")
    panel: Panel | None = None
    panel_curves: PanelCurveSettings = PanelCurveSettings()
    weather: Weather | None = None
    converter: PowerChain | None = None
    load: Load | None = None
    trackers: dict[str, AnyTracker] = Field(default_factory=dict, description="trackers that are tried, by name")
    tracking: Tracking | None = Field(default=None, description="what the trackers are tried on")
    battery: Battery
    second_battery: Battery | None = Field(default=None, description="charged in the same way, to be held against it")
    modes: dict[str, Mode]
    run: tuple[str, ...] = Field(min_length=1, description="names of the modes that are charged")
    comparisons: dict[str, Comparison] = Field(min_length=1)
    charge: ChargeSettings
    engine: EngineSettings = EngineSettings()
    ensemble: EnsembleSettings = EnsembleSettings(samples=0)
    day: Day | None = Field(default=None, description="days in the sun, held against each other")
    trade_off: TradeOff | None = Field(default=None, description="charge time against peak temperature")
    chaos: ChaosSettings | None = None
    network: NetworkStudy | None = Field(default=None, description="the network that commands a charger")
    objective: ReflexFrequency | None = Field(default=None, description="what a search minimises")
    design: Design | None = Field(default=None, description="parameter design that tunes the search")
    search: AnySettings | None = Field(default=None, description="the search whose result others may ask for")
    oracle: AnySettings | None = Field(default=None, description="the sweep it is held against")
    staging: Staging | None = Field(default=None, description="search for the currents of a staged charge")
    calibrations: dict[str, Battery] = Field(default_factory=dict, description="batteries it is repeated on, by name")
    functions: FunctionStudy | None = Field(default=None, description="searches on test functions")
    validation: Validation | None = Field(default=None, description="what the engine is held against, and nothing else")
    figures: dict[str, FigureCard] = Field(default_factory=dict)
    published: dict[str, Statement] = Field(default_factory=dict)
    sources: dict[str, Source] = Field(default_factory=dict)
    overrides: tuple[str, ...] = Field(default=(), description="the overrides, without the choice of the study")
    configuration: dict[str, Any] = Field(description="the composed configuration as plain data")

    def parameter_sections(self) -> tuple[str, ...]:
        """Return the key paths below which every number is a physical parameter with a source."""
        return sections(tuple(self.modes), tuple(self.calibrations))

    def parameters(self, section: str) -> Iterator[tuple[str, Any]]:
        """Yield key path and value of every parameter below a section."""
        here: Any = self.configuration
        for key in section.split("."):
            here = here.get(key, {})
        return leaves(here, section)


def sections(modes_in_use: tuple[str, ...], calibrations: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the sections of the configuration that hold physical parameters, for the modes and calibrations in use."""
    modes = tuple(f"modes.{name}" for name in modes_in_use)
    charge = ("charge.initial_soc", "charge.ambient_c")
    return (
        *("panel", "weather", "converter", "load", "trackers", "tracking", "battery", "second_battery"),
        *modes,
        *charge,
        *("objective", "design", "search", "oracle", "network", "trade_off", "functions", "day"),
        *("staging", "validation", *(f"calibrations.{name}" for name in calibrations)),
    )


def study_from(composed: Composed) -> Study:
    """Validate a composed configuration.

    Raises
    ------
    UserError : the first kind of mistake found, each instance with file, key path, value and what is allowed.
    """
    values, written = split(composed.tree)
    values = panels.by_name(composed, _choose_modes(composed, _without_twin(values)), written)
    try:
        study = Study(
            **values,
            overrides=tuple(word for word in composed.overrides if not word.startswith("study=")),
            configuration=values,
        )
    except ValidationError as error:
        raise explain(error, values, "", composed.origin, Study) from None
    taken = {path: source for path, source in written.items() if not _unused(path, values)}
    sources = attribute(composed, values, taken, study.parameter_sections())
    study = study.model_copy(update={"sources": sources})
    _check_together(composed, study)
    return study


def _choose_modes(composed: Composed, values: dict[str, Any]) -> dict[str, Any]:
    """Keep the modes that are run or referred to; every file of conf/modes is known, none has to be used."""
    modes = values.get("modes")
    if not isinstance(modes, Mapping):
        raise UserError(f"{composed.origin('modes')}: modes: value {modes!r}; allowed is a mapping with `run` in it")
    known = {name: mode for name, mode in modes.items() if name != "run"}
    run = modes.get("run")
    if not isinstance(run, list) or not run or not all(isinstance(name, str) for name in run):
        raise UserError(
            f"{composed.origin('modes.run')}: modes.run: value {run!r}; allowed is a list of modes, "
            f"{best_matches('', known)}"
        )
    wanted = [*run]
    comparisons = values.get("comparisons")
    for name, comparison in comparisons.items() if isinstance(comparisons, Mapping) else ():
        reference = comparison.get("mean_current_of") if isinstance(comparison, Mapping) else None
        if isinstance(reference, str):
            wanted.append(reference)
            if reference not in known:
                path = f"comparisons.{name}.mean_current_of"
                raise UserError(
                    f"{composed.origin(path)}: {path}: no mode {reference!r}; {best_matches(str(reference), known)}"
                )
    objective = values.get("objective")
    searched = objective.get("mode") if isinstance(objective, Mapping) else None
    if isinstance(searched, str) and searched in known:
        wanted.append(searched)
    staging = values.get("staging")
    printed = staging.get("mode") if isinstance(staging, Mapping) else None
    if isinstance(printed, str) and printed in known:
        wanted.append(printed)
    for name in run:
        if name not in known:
            raise UserError(
                f"{composed.origin('modes.run')}: modes.run: no mode {name!r} in conf/modes; "
                f"{best_matches(str(name), known)}"
            )
    if len(set(run)) < len(run):
        raise UserError(f"{composed.origin('modes.run')}: modes.run: value {run}; each mode may stand there once")
    return values | {"modes": {name: known[name] for name in dict.fromkeys(wanted)}, "run": list(run)}


def _without_twin(values: dict[str, Any]) -> dict[str, Any]:
    """Leave out a second battery that is the first one: there is nothing to hold against it."""
    twin = values.get("second_battery") == values.get("battery")
    return {key: value for key, value in values.items() if key != "second_battery"} if twin else values


def _unused(path: str, values: Mapping[str, Any]) -> bool:
    """Tell whether a source belongs to a mode or a second battery that this run leaves out."""
    keys = path.split(".")
    left_out = keys[0] == "modes" and len(keys) > 1 and keys[1] not in values["modes"]
    return left_out or (keys[0] == "second_battery" and keys[0] not in values)


def _check_together(composed: Composed, study: Study) -> None:
    """Check what no record can check alone."""
    with _explained(composed):
        # A mode may take its values from another: the one that an override changed is told first.
        for name in sorted(study.modes, key=lambda name: not _overridden(composed, f"modes.{name}")):
            with _below(composed, f"modes.{name}"):
                charge_checks.check(study.battery, study.modes[name], study.charge)
                if study.second_battery is not None:
                    _check_second(study.second_battery, study.modes[name], study.charge)
        if study.panel is not None:
            if study.weather is None or study.converter is None or study.load is None:
                raise UserError("panel: a study with a panel needs weather, converter and load")
            power = study.panel.approximate_power_w(*daily.brightest(study.weather))
            voltage = study.panel.max_power_voltage_v * study.panel.panels_in_series
            check_supply(power, voltage, study.converter, study.load)
        staged.check(study)
        searching.check(study)
        switching.check(study)
        daily.check(study)
        tables = {path.stem for path in reference_tables()}
        if study.design is not None and study.design.printed not in {None, *tables}:
            printed = str(study.design.printed)
            raise UserError(f"design.printed: no table {printed!r}; {best_matches(printed, tables)}")
        own = f"{study.study.name}."
        fitted = {source.to for source in study.sources.values() if source.to is not None}
        calibrated = {name.removeprefix(own) for name in fitted if name.startswith(own)}
        marks, numbers = study.charge.soc_marks, _numbers(study)
        published_checks.check(study.published, _makeable(study), marks, calibrated, numbers)


def _check_second(battery: Battery, mode: Mode, charge: ChargeSettings) -> None:
    try:
        charge_checks.check(battery, mode, charge)
    except UserError as error:
        raise UserError(f"{error}; meant is the second battery, {battery.name}") from None


def _makeable(study: Study) -> set[str]:
    """Return every input the study could make, also with modes that this run leaves out."""
    supplied = {"panel", "supply"} if study.panel is not None else set()
    charges = {f"charge/{comparison}/{mode}" for comparison in study.comparisons for mode in options("modes")}
    parts = ("chaos", "objective", "trade_off", "functions")
    supplied |= {name for name in parts if getattr(study, name) is not None}
    supplied |= {"switched"} if study.converter is not None else set()
    supplied |= set(network_quantities()) if study.network is not None else set()
    supplied |= {"staging", "front"} if study.staging is not None else set()
    supplied |= set(searching.found_values(study)) | ({"tuning"} if study.design is not None else set())
    return supplied | charges | {f"reference/{path.stem}" for path in reference_tables()}


def _numbers(study: Study) -> dict[str, set[str]]:
    """Return the named numbers that the steps of the search could find, also for modes that this run leaves out."""
    bins = () if study.chaos is None else study.chaos.bins
    factors = () if study.design is None else tuple(study.design.factors)
    numbers = found_quantities(bins, options("modes"), factors, searching.searches(study))
    if study.functions is not None:
        numbers["functions"] = function_names(study.functions)
    # Statements on the swarm are not checkable under another algorithm, which is no mistake in them.
    if study.search is not None and study.search.kind != "swarm":
        del numbers["search"]
    if study.trade_off is not None:
        numbers["trade_off"] = study.trade_off.quantities()
    return numbers | staged.quantities(study) | ({} if study.network is None else network_quantities())


def _overridden(composed: Composed, path: str) -> list[str]:
    """Return the overrides below a key path."""
    return [word for word in composed.overrides if word.lstrip("+").startswith(f"{path}.")]


@contextmanager
def _below(composed: Composed, path: str) -> Iterator[None]:
    """Put a key path before the message of a check, and the overrides below it, which are the likely cause."""
    try:
        yield
    except (UserError, ValueError) as error:
        words = _overridden(composed, path)
        cause = f"override {' '.join(words)}: " if words else ""
        raise UserError(f"{cause}{path}.{error}") from None


@contextmanager
def _explained(composed: Composed) -> Iterator[None]:
    """Put the file before the message of a check, which begins with its key path."""
    try:
        yield
    except UserError as error:
        message = str(error)
        path = message.split(":")[0].split(" ")[0]
        raise UserError(message if path == "override" else f"{composed.origin(path)}: {message}") from None
