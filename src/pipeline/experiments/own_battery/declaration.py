"""Own measurements: read, seen, fitted, the battery's card written, and the battery charged in every mode."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from pydantic import Field

from pipeline.errors import UserError
from pipeline.experiments.own_battery.records import Fit, Measured, names_of
from pipeline.experiments.own_battery.tables import CHARGES, FITTED, FITTED_NUMBERS, READ
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.own_files import digest
from pipeline.record import Record


class OwnBatteryPart(Record):
    """A user's measurement, and how a card is made of it."""

    measured: Measured | None = Field(default=None, description="files that a cycler or a logger wrote")
    own_battery: Fit = Field(default=Fit(), description="how a card is fitted to them")


def _content(config: Any) -> dict[str, Any]:
    return {
        "measured": plain(config.measured),
        "sha256": [digest(Path(file)) for file in config.measured.files],
        "battery": untitled(config.battery, config.battery.name),
    }


def _reading_settings(config: Any) -> dict[str, Any]:
    chosen = config.own_battery
    return _content(config) | {"initial_soc": list(chosen.initial_soc), "held_out": plain(chosen.held_out)}


def _fit_settings(config: Any) -> dict[str, Any]:
    sources = {path: plain(source) for path, source in config.sources_below("battery").items()}
    return _content(config) | {"fit": plain(config.own_battery), "sources": sources, "seed": config.seed}


def _charge_settings(config: Any, modes: list[str]) -> dict[str, Any]:
    return {
        "modes": {name: untitled(config.modes[name], name) for name in modes},
        "charge": config.charge,
        "engine": config.engine,
    }


def _fit_effort(config: Any) -> Effort:
    mib = sum(Path(file).stat().st_size for file in config.measured.files if Path(file).is_file()) / 2**20
    chosen = config.own_battery
    return Effort(4e8 + 4e8 * mib, 20.0 + 30.0 * chosen.starts, ("measured.file", "own_battery.starts"))


READING = Step(
    "own_reading",
    rule="read_measurement",
    message="Measurement: reading and segments: {chunk}",
    settings=_reading_settings,
    reads=("measured", "own_battery.initial_soc", "own_battery.held_out", "battery"),
    tables=READ,
    usual_table="segments",
)
FITTING = Step(
    "own_fit",
    rule="fit_measurement",
    message="Measurement: fit of the battery's card: {chunk}",
    settings=_fit_settings,
    effort=Footprint(_fit_effort, start_s=6.0),
    reads=("measured", "own_battery", "battery", "seed"),
    takes=("own_reading",),
    tables=FITTED,
    usual_table="quantities",
    quantities=FITTED_NUMBERS,
)
CHARGING = Step(
    "own_charges",
    rule="charge_fitted_battery",
    message="Charges of the fitted battery: {chunk}",
    settings=_charge_settings,
    reads=("modes.{modes}", "charge", "engine"),
    takes=("own_fit",),
    tables=CHARGES,
    usual_table="charges",
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield what is made of a measurement, where a study has one."""
    if study.measured is None:
        return
    yield Node(READING, "own_reading", study.study.name, shown=READING.places("measured"))
    shown = {**FITTING.places("fit"), "battery.yaml": "battery.yaml"}
    yield Node(FITTING, "own_fit", study.study.name, inputs={"own_reading": "own_reading"}, shown=shown)
    which = {"modes": list(study.run)}
    yield Node(CHARGING, "own_charges", study.study.name, which, {"own_fit": "own_fit"}, CHARGING.places("charges"))


def check(study: Any) -> None:
    """Refuse a measurement that cannot be used.

    Raises
    ------
    UserError : no file, one that cannot be read, what it does not say, a hold-out or a start that does not fit it.
    """
    measured, chosen = study.measured, study.own_battery
    if measured is None:
        return
    if not measured.files:
        raise UserError(
            "measured.file: no file is named; give a CSV, Parquet or Excel file of time, voltage and current, "
            "measured.file=FILE"
        )
    twice = next((name for name in measured.files if measured.files.count(name) > 1), None)
    if twice is not None:
        raise UserError(f"measured.more: {twice!r} is named twice; each file counts once")
    for name in chosen.held_out.files:
        named = [file for file in measured.files if name in names_of(file)]
        if not named:
            raise UserError(f"own_battery.held_out.files: {name!r} is none of {', '.join(measured.files)}")
        if len(named) > 1:
            raise UserError(f"own_battery.held_out.files: {name!r} is the name of {' and '.join(named)}; give its path")
    if all(map(chosen.held_out.takes, measured.files)):
        raise UserError("own_battery.held_out.files: every file is held out; leave one for the fit")
    if chosen.initial_soc and len(chosen.initial_soc) != len(measured.files):
        raise UserError(
            f"own_battery.initial_soc: {len(chosen.initial_soc)} values for {len(measured.files)} files; give one each"
        )
    from pipeline.experiments.own_battery.plausible import check_held_out, check_series

    try:
        check_series(measured, study.battery)
    except UserError as error:
        raise UserError(f"measured.file: {error}".replace("measured.file: measured.file:", "measured.file:")) from None
    check_held_out(measured, study.battery, chosen)


def _remarks(study: Any, kinds: Collection[str]) -> Iterator[str]:
    """Yield what the files were taken for and what was done to them."""
    if study.measured is None or not study.measured.files:
        return
    from pipeline.experiments.own_battery.plausible import doubtful_voltage
    from pipeline.experiments.own_battery.reading import measured_series

    doubt = doubtful_voltage(study.battery, study.own_battery)
    if doubt is not None:
        yield doubt
    for series in measured_series(study.measured):
        yield from (f"measured.file: {Path(series.file).name}: {line}" for line in series.said)


def _label(config: Any) -> dict[str, Any]:
    if config.measured is None:
        return {}
    return {"files": [Path(file).name for file in config.measured.files], "title": config.own_battery.title}


EXPERIMENT = Experiment(
    title="own measurements: a battery's card from a cycler's file",
    steps=(READING, FITTING, CHARGING),
    nodes=nodes,
    part=OwnBatteryPart,
    checks=(check,),
    remarks=_remarks,
    inputs=lambda study: ("own_reading", "own_fit", "own_charges") if study.measured is not None else (),
    fields=lambda study: {} if study.measured is None else {FITTING.name: {}},
    labels={"own": Label(_label, ("measured.file", "measured.more", "own_battery.title"))},
    alone=lambda study: study.measured is not None,
    tells="telling",
)
