"""Batteries and modes by the names of their files, composed once and kept until a file changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from pydantic import ValidationError

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.config.compose import Composed, compose_tree, options
from pipeline.config.inheritance import CONF, content, file_of
from pipeline.config.messages import Origin, explain
from pipeline.config.planning import run_of
from pipeline.config.sources import split
from pipeline.config.yaml_file import state
from pipeline.errors import UserError, best_matches
from pipeline.kernel import store
from pipeline.kernel.draft import references
from pipeline.kernel.planfile import command
from pipeline.kernel.run import resolve
from pipeline.record import Record

R = TypeVar("R", bound=Record)


class Read:
    """A composed configuration of a battery and every mode, and the records made of it so far."""

    def __init__(self, composed: Composed) -> None:
        self.origin = composed.origin
        self.values = split(composed.tree)[0]
        self._files = {layer.file: state(layer.file) for layer in composed.layers}
        self._records: dict[str, Record] = {}

    def current(self) -> bool:
        """Tell whether every file that took part is as it was."""
        return all(path.is_file() and state(path) == before for path, before in self._files.items())

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
    raise UserError(
        f"modes.{name}: waits for what the step {' and '.join(steps)} finds, which is not in {store.RESULTS}/; {make}, "
        "or give a number"
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
