"""The part of the configuration that charges take: batteries, modes, comparisons, the settings of a charge."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

from pydantic import Field, model_validator

from pipeline.cell.records import Battery, cuts
from pipeline.charge.checks import check
from pipeline.charge.feasible import check_range, notices, remarks, visited
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.config.compose import Composed
from pipeline.config.many import Unrefused
from pipeline.errors import UserError, best_matches
from pipeline.published.ensemble import EnsembleSettings
from pipeline.record import Record

StopName = Literal["soc", "voltage_v", "current_a", "temperature_c", "voltage_drop_v", "temperature_rate_k_s"]


class Comparison(Record):
    """How modes are made comparable."""

    title: str
    peak_current_of: str | None = Field(
        default=None, description="mode whose largest current every mode's is set to; none: as configured"
    )
    mean_current_of: str | None = Field(
        default=None, description="mode whose constant current every mode's mean is set to; none: as configured"
    )
    stops: tuple[StopName, ...] | None = Field(
        default=None, description="the stops of the modes that count, beside the time; none: all of them"
    )

    @model_validator(mode="after")
    def _one_level(self) -> Comparison:
        if self.peak_current_of is not None and self.mean_current_of is not None:
            raise ValueError("peak_current_of and mean_current_of exclude each other; give one")
        return self

    @property
    def reference(self) -> str | None:
        """Return the mode whose current sets those of the others; none where they are as configured."""
        return self.peak_current_of or self.mean_current_of

    def level(self) -> dict[str, Any]:
        """Return it as the settings of a step hold it, for `level_of`."""
        return {"reference": self.reference, "mean": self.mean_current_of is not None}


class ChargesPart(Record):
    """Batteries, modes and how they are charged."""

    battery: Battery
    second_battery: Battery | None = Field(default=None, description="charged in the same way, for comparison")
    modes: dict[str, Mode]
    run: tuple[str, ...] = Field(min_length=1, description="names of the modes that are charged")
    comparisons: dict[str, Comparison] = Field(min_length=1)
    charge: ChargeSettings
    engine: EngineSettings = EngineSettings()
    ensemble: EnsembleSettings = EnsembleSettings()


def prepare(composed: Composed, values: dict[str, Any], written: dict[str, Any]) -> dict[str, Any]:
    """Take `run` out of the modes, and leave out a second battery that is the first one.

    Arguments
    ---------
    values : the composed tree without sources.
    written : key path -> source, as written.

    Raises
    ------
    UserError : no modes, or one named that is not there.
    """
    modes = values.get("modes")
    if not isinstance(modes, Mapping):
        raise UserError(f"{composed.origin('modes')}: modes: value {modes!r}; allowed is a mapping with `run` in it")
    known = {name: mode for name, mode in modes.items() if name != "run"}
    run = _run(composed, modes.get("run"), known)
    _check_references(composed, values.get("comparisons"), known)
    if values.get("second_battery") == values.get("battery"):
        # There is nothing to compare.
        values = {key: value for key, value in values.items() if key != "second_battery"}
    return values | {"modes": known, "run": run}


def check_modes(study: Any) -> None:
    """Refuse a mode that cannot be run on a battery of the study.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    # A mode may take its values from another: the one that an override changed is told first.
    for path, battery in batteries(study).items():
        for name in study.modes:
            low, high = visited(battery, study.modes[name], study.charge)
            check_range(path, battery, low, high, study.charge.start_c)
    for name in sorted(study.modes, key=lambda name: not _overridden(study.overrides, f"modes.{name}")):
        for battery in (study.battery, study.second_battery):
            if battery is not None:
                meant = f"; meant is the second battery, {battery.name}" if battery is study.second_battery else ""
                _check(f"modes.{name}", battery, study.modes[name], study.charge, meant)


_CHECK = Unrefused(check)


def batteries(study: Any) -> dict[str, Battery]:
    """Return key path -> battery, for every battery of a study: the second one and calibrations too."""
    found = {"battery": study.battery, "second_battery": study.second_battery}
    others = {f"calibrations.{name}": one for name, one in getattr(study, "calibrations", {}).items()}
    return {path: one for path, one in (found | others).items() if one is not None}


def remarks_on_modes(study: Any, second: bool) -> Iterator[str]:
    """Yield what whoever plans the charges should know of them; `second`: whether the second battery is charged."""
    used = {path: battery for path, battery in batteries(study).items() if second or path != "second_battery"}
    for path, battery in used.items():
        yield from (f"{path}.{told}" for told in cuts(battery))
    if "battery" in used:
        yield from (f"battery.{told}" for told in remarks(used["battery"], study.charge))
    for battery in (used[path] for path in ("battery", "second_battery") if path in used):
        for name in study.run:
            yield from (f"modes.{name}.{told}" for told in notices(battery, study.modes[name], study.charge))


def _check(path: str, battery: Battery, mode: Mode, charge: ChargeSettings, meant: str) -> None:
    try:
        _CHECK(battery, mode, charge)
    except (UserError, ValueError) as error:
        raise UserError(f"{path}.{error}{meant}") from None


def _overridden(overrides: tuple[str, ...], path: str) -> bool:
    return any(word.lstrip("+").startswith(f"{path}.") for word in overrides)


def _run(composed: Composed, run: Any, known: Mapping[str, Any]) -> list[str]:
    """Return the names of the modes that are charged; every file of conf/modes is known, none has to be used."""
    where = f"{composed.origin('modes.run')}: modes.run"
    if not isinstance(run, list) or not run or not all(isinstance(name, str) for name in run):
        raise UserError(f"{where}: value {run!r}; allowed is a list of modes, {best_matches('', known)}")
    for name in run:
        if name not in known:
            raise UserError(f"{where}: no mode {name!r} in conf/modes; {best_matches(name, known)}")
    if len(set(run)) < len(run):
        raise UserError(f"{where}: value {run}; each mode may stand there once")
    return list(run)


def _check_references(composed: Composed, comparisons: Any, known: Mapping[str, Any]) -> None:
    for name, comparison in comparisons.items() if isinstance(comparisons, Mapping) else ():
        for key in ("peak_current_of", "mean_current_of"):
            reference = comparison.get(key) if isinstance(comparison, Mapping) else None
            if isinstance(reference, str) and reference not in known:
                path = f"comparisons.{name}.{key}"
                raise UserError(
                    f"{composed.origin(path)}: {path}: no mode {reference!r}; {best_matches(reference, known)}"
                )
