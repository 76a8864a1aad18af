"""Batteries, modes and panels by their names; files are composed once and kept until one changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeVar, cast

from pydantic import ValidationError

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.config.compose import Composed, compose_tree, options
from pipeline.config.inheritance import CONF, content, file_of
from pipeline.config.messages import Origin, explain
from pipeline.config.planning import run_of
from pipeline.config.sources import split
from pipeline.config.yaml_file import state
from pipeline.converter.records import fitting_bus_v
from pipeline.errors import UserError, best_matches
from pipeline.experiments.supply import declaration as supplied
from pipeline.experiments.supply.named_panel import by_name
from pipeline.kernel import store
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.draft import plain, references
from pipeline.kernel.planfile import command
from pipeline.kernel.run import resolve
from pipeline.panel import database
from pipeline.record import Record

if TYPE_CHECKING:
    from pipeline.charge.simulate import Supply

R = TypeVar("R", bound=Record)
BETWEEN = {"weather": "constant", "converter": "fixed_efficiency", "load": "master_system"}
"""Groups that lie between a panel and a battery -> what is taken of each where nothing is said of it."""


class NotFound(UserError):
    """A mode waits for values that steps of a study find, and they are not there yet."""

    def __init__(self, message: str, study: str | None, steps: Sequence[str]) -> None:
        super().__init__(message)
        self.study, self.steps = study, tuple(steps)


@dataclass(frozen=True)
class Fed:
    """A panel with what lies between it and a battery; `told` says in words what it is."""

    supply: Supply
    told: str


class Read:
    """A composed configuration of a battery and every mode, and the records made of it so far."""

    def __init__(self, composed: Composed) -> None:
        self.origin = composed.origin
        self.values, self._sources = split(composed.tree)
        self._files = {layer.file: state(layer.file) for layer in composed.layers}
        self._records: dict[str, Record] = {}

    def current(self) -> bool:
        """Tell whether every file that took part is as it was."""
        return all(path.is_file() and state(path) == before for path, before in self._files.items())

    def followers(self, mode: str) -> dict[str, str]:
        """Return the knobs of a mode that are as others of it: their names and those of the others (`same_as`)."""
        begin = f"modes.{mode}."
        return {
            path.removeprefix(begin): str(source["same_as"])
            for path, source in self._sources.items()
            if path.startswith(begin) and source.get("same_as")
        }

    def record(self, path: str, kind: type[R], values: Mapping[str, Any]) -> R:
        """Return the record at a key path; validated once."""
        if path not in self._records:
            self._records[path] = validated(kind, values, path, self.origin)
        return cast(R, self._records[path])


_KEPT: dict[str | None, Read] = {}


def battery(name: str) -> Battery:
    """Return a battery of `conf/battery`.

    Arguments
    ---------
    name : of its file.

    Raises
    ------
    UserError : no such file, or one that does not validate.

    >>> import pipeline as cp
    >>> cp.battery("lead_acid_12v7ah").capacity_ah
    7.0
    """
    read = _read(name)
    return read.record("battery", Battery, read.values["battery"])


def mode(name: str, beside: str | None = None) -> Mode:
    """Return a mode of `conf/modes`, its found values still to be found.

    Arguments
    ---------
    name : of its file.
    beside : name of the battery whose values its file may refer to.

    Raises
    ------
    UserError : no such file, or one that does not validate.

    >>> import pipeline as cp
    >>> cp.mode("cc_cv").knobs
    {'max_current_a': 2.1, 'voltage_v': 14.4}
    """
    read, values = written_mode(name, beside)
    return read.record(f"modes.{name}", Mode, values)


def written_mode(name: str, beside: str | None = None) -> tuple[Read, dict[str, Any]]:
    """Return a mode as it is written, and the reading that it stands in."""
    known = options("modes")
    if name not in known:
        raise UserError(f"modes: no mode {name!r} in conf/modes; {best_matches(name, known)}")
    read = _read(beside)
    return read, read.values["modes"][name]


def with_found(name: str, values: dict[str, Any]) -> dict[str, Any]:
    """Return a written mode with the values that a study's steps found for it, as they lie in `results/`.

    Raises
    ------
    UserError : they are not there; how they are made is said.
    """
    steps = sorted(set(references(values)))
    if not steps:
        return values
    studies = [study for study in options("study") if name in _charged(study)]
    for study in studies:
        run = run_of([f"study={study}"])
        folders = {step: store.artefact(store.RESULTS, step, run.keys[step]) for step in steps if step in run.keys}
        if len(folders) == len(steps) and all(store.damage(folder) is None for folder in folders.values()):
            return dict(resolve(values, folders))
    make = f"make it with `{command(studies[0], ())}`" if studies else "no study charges with it"
    told = (
        f"modes.{name}: waits for what the step {' and '.join(steps)} finds, which is not in {store.RESULTS}/; {make}, "
        "or give a number"
    )
    raise NotFound(told, studies[0] if studies else None, steps)


def fed(panel: str, words: Sequence[str] = ()) -> Fed:
    """Return the supply of a panel: its maximum power through tracker, converters and load to the battery.

    Arguments
    ---------
    panel : name of a file of `conf/panel`, or of a panel of pvlib's databases.
    words : overrides as at the command line, of panel, weather, converter and load. What they leave out is constant
        1000 W/m2 and 25 degC, converters of fixed efficiencies, no load, and a bus above the panel's voltage.

    Raises
    ------
    UserError : an unknown name, a value out of its range, or a supply that can never charge.

    >>> from pipeline.notebook.named import fed
    >>> fed("kc65t").told
    'Kyocera KC65T (65 W), constant 1000 W/m2, 25 degC, fixed efficiencies, no load: at most 56.5 W at the battery'
    """
    chosen = {word.split("=")[0].lstrip("+") for word in words}
    between = [f"+{group}={option}" for group, option in BETWEEN.items() if group not in chosen]
    load = [] if any(key.split(".")[0] == "load" for key in chosen) else ["load.power_w=0.0"]
    own = [f"+{word.lstrip('+')}" if word.split("=")[0] in BETWEEN else word for word in words]
    typed = ["~study", *_panel_words(panel), *between, *load, *own]
    part = _supplied(typed)
    assert part.panel is not None
    if "converter.bus_voltage_v" not in chosen and part.converter.bus_voltage_v <= part.panel.string_voltage_v:
        part = _supplied([*typed, f"converter.bus_voltage_v={fitting_bus_v(part.panel.string_voltage_v):g}"])
    supplied.check(part)
    return _through(part)


def _panel_words(panel: str) -> list[str]:
    if panel in options("panel"):
        return [f"+panel={panel}"]
    name = panel.translate(database.PLAIN)
    cec, sandia = (name in database.names(one) for one in ("cec", "sandia"))
    return ["+panel=database", f'panel.name="{panel}"', *["panel.database=sandia"] * (sandia and not cec)]


def _supplied(words: Sequence[str]) -> Any:
    """Return a panel and what lies behind it, validated."""
    composed = compose_tree(words)
    values, written = split(composed.tree)
    values = by_name(composed, values, written)
    own = {name: values[name] for name in supplied.SupplyPart.model_fields if name in values}
    return validated(supplied.SupplyPart, own, "", composed.origin)


def _through(part: Any) -> Fed:
    """Run the step `supply` on the panel's curve, so that what charges a battery is what a study's charges have."""
    from pipeline.experiments.charges.charge import supply
    from pipeline.experiments.supply import supply as step
    from pipeline.panel.curves import parameters
    from pipeline.panel.single_diode import fit

    with TemporaryDirectory() as folder:
        made = {name: Path(folder) / name for name in ("panel", "supply")}
        for place in made.values():
            place.mkdir()
        inputs = Inputs(made, {"panel": supplied.PANEL, "supply": supplied.SUPPLIED})
        Output(made["panel"], supplied.PANEL).write("parameters", parameters(part.panel, fit(part.panel)))
        settings = plain(dict(supplied.SUPPLY_STEP.settings(part)))
        step.run(settings, inputs, Output(made["supply"], supplied.SUPPLIED))
        found = supply(inputs)
    panels = part.panel.panels_in_series * part.panel.panels_in_parallel
    count = f"{panels} x " if panels > 1 else ""
    load = f"load {part.load.title}, {part.load.power_w:g} W" if part.load.power_w else "no load"
    return Fed(
        found,
        f"{count}{part.panel.title} ({part.panel.max_power_w:.4g} W), {part.weather.title}, {part.converter.title}, "
        f"{load}: at most {found.power_w.max():.3g} W at the battery",
    )


def validated(record: type[R], values: Mapping[str, Any], path: str, origin: Origin) -> R:
    """Return a record; raise `UserError` as at the command line."""
    try:
        return record.model_validate(values)
    except ValidationError as error:
        raise explain(error, values, path, origin, record) from None


def _charged(study: str) -> list[str]:
    """Return the modes that a study charges with, as its file has them."""
    modes = content(file_of(CONF, f"study/{study}.yaml")).get("modes")
    run = modes.get("run") if isinstance(modes, Mapping) else None
    return run if isinstance(run, list) else []


def _read(name: str | None) -> Read:
    """Return every mode beside a battery, composed again only where a file changed."""
    kept = _KEPT.get(name)
    if kept is None or not kept.current():
        words = ["~study", *([f"+battery={name}"] if name is not None else [])]
        kept = _KEPT[name] = Read(compose_tree(words))
    return kept
