"""The root record of a study: assembled from what the experiments declare, validated and checked."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Any

from pydantic import Field, ValidationError, create_model, field_validator

from pipeline.config.compose import Composed, options
from pipeline.config.effort import Limits
from pipeline.config.messages import explain
from pipeline.config.sources import Source, attribute, check_references, leaves, split
from pipeline.errors import UserError, best_matches
from pipeline.kernel import registry
from pipeline.published.vocabulary import check_statements
from pipeline.record import Record

_LONGEST = 2000
# Folders of results/ and targets that belong to no experiment.
_OWN = frozenset({"all", "benchmarks", "logs", "plan", "receipts", "report", "store"})


def reserved() -> frozenset[str]:
    """Return the names that no study may have: targets of the workflow and folders of results/."""
    return _OWN | set(registry.targets())


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
        if name in reserved():
            raise ValueError(f"{name!r} is taken; not allowed are {', '.join(sorted(reserved()))}")
        return name

    @field_validator("on_request")
    @classmethod
    def _targets_free(cls, on_request: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        for target, overrides in on_request.items():
            if target in reserved() | set(options("study")) or not target.isidentifier():
                raise ValueError(f"target {target!r} is taken or no plain name; take another")
            if not overrides:
                raise ValueError(f"target {target!r} has no overrides; it would be the study itself")
        return on_request


class StudyRoot(Record):
    """What every study has; its experiments add the rest."""

    study: StudyCard
    seed: int = Field(ge=0, description="root of every random stream")
    limits: Limits = Field(default=Limits(), description="what a run may take; part of no key")
    sources: dict[str, Source] = Field(default_factory=dict)
    overrides: tuple[str, ...] = Field(default=(), description="the overrides, without the choice of the study")
    configuration: dict[str, Any] = Field(description="the composed configuration as plain data")

    def parameter_sections(self) -> tuple[str, ...]:
        """Return the key paths below which every number is a physical parameter with a source."""
        declared = [path for one in registry.experiments().values() for path in one.parameters]
        return tuple(found for path in declared for found in _entries(path, self.configuration))

    def parameters(self, section: str) -> Iterator[tuple[str, Any]]:
        """Yield key path and value of every parameter below a section."""
        here: Any = self.configuration
        for key in section.split("."):
            here = here.get(key, {})
        return leaves(here, section)


@cache
def study_type() -> type[StudyRoot]:
    """Return the root record: what every study has, and the part that each experiment declares."""
    parts = [one.part for one in registry.experiments().values() if one.part is not None]
    doc = "A whole study. Parts that a study does without stay empty."
    return create_model("Study", __base__=(StudyRoot, *parts), __doc__=doc)


def study_from(composed: Composed) -> Any:
    """Validate a composed configuration.

    Returns
    -------
    The root record, of the type `study_type()`.

    Raises
    ------
    UserError : the first kind of mistake found, each instance with file, key path, value and what is allowed.
    """
    values, written = split(composed.tree)
    _refuse_own(composed, values, written)
    for one in registry.experiments().values():
        if one.prepare is not None:
            values = one.prepare(composed, values, written)
    whole = values
    values, left_out = without_unnamed(values)
    # What a person changes is judged even where nothing takes it.
    touched = {path for path in left_out if composed.touched(path)}
    if touched:
        _validated(composed, without_unnamed(whole, touched)[0])
    study = _validated(composed, values)
    taken = {path: source for path, source in written.items() if not _of_left_out(path, values, left_out)}
    sources = attribute(composed, values, taken, study.parameter_sections())
    study = study.model_copy(update={"sources": sources})
    _check(composed, study)
    return study


def _apart(word: str) -> bool:
    """Tell whether an override makes no other run of a study: the choice of the study, and what the run may take."""
    return word.startswith("study=") or word.lstrip("+~").split("=")[0].split(".")[0] == "limits"


def _refuse_own(composed: Composed, values: Mapping[str, Any], written: Mapping[str, Any]) -> None:
    """Refuse what the program itself puts at the root, and sources of what is not there."""
    for path in sorted({"overrides", "configuration", "run"} & set(values)):
        raise UserError(f"{composed.origin(path)}: {path}: no part of a configuration that can be given")
    for path in written:
        if path.split(".")[0] not in values and composed.touched("sources"):
            raise UserError(
                f"{composed.origin(f'sources.{path}')}: sources.{path}: no such value; {best_matches(path, values)}"
            )


def _validated(composed: Composed, values: dict[str, Any]) -> Any:
    model = study_type()
    try:
        return model(
            **values,
            overrides=tuple(word for word in composed.overrides if not _apart(word)),
            # What a run may take changes nothing of what it makes.
            configuration={key: value for key, value in values.items() if key != "limits"},
        )
    except ValidationError as error:
        raise explain(error, values, "", composed.origin, model) from None


def without_unnamed(values: dict[str, Any], keep: Collection[str] = ()) -> tuple[dict[str, Any], set[str]]:
    """Leave out the entries of mappings that nothing names; every file of conf/modes is known, none has to be used.

    Arguments
    ---------
    keep : key paths of entries that stay although nothing names them.

    Returns
    -------
    The values, and the key paths of the entries left out.
    """
    # Those of the experiment that has the mapping come first: their order is that of its entries.
    known = registry.experiments().values()
    own = [
        (path, to) for one in known for path, to in one.refers.items() if to in getattr(one.part, "model_fields", ())
    ]
    refers = list(dict.fromkeys([*own, *(item for one in known for item in one.refers.items())]))
    named: dict[str, list[str]] = {mapping: [] for _, mapping in refers}
    for path, mapping in refers:
        for word in _words(path, values):
            named[mapping] += [word] if word not in named[mapping] else []
    left_out = set[str]()
    for mapping, words in named.items():
        entries = values.get(mapping)
        if isinstance(entries, Mapping):
            words += [name for name in entries if f"{mapping}.{name}" in keep]
            left_out |= {f"{mapping}.{name}" for name in entries if name not in words}
            values = values | {mapping: {name: entries[name] for name in words if name in entries}}
    return values, left_out


def _words(path: str, values: Any) -> Iterator[str]:
    """Yield the words at a key path, in which `*` stands for every entry of a mapping."""
    here = [values]
    for key in path.split("."):
        here = [one for found in here if isinstance(found, Mapping)
                for one in (found.values() if key == "*" else [found.get(key)])]  # fmt: skip
    for found in here:
        yield from (word for word in (found if isinstance(found, list) else [found]) if isinstance(word, str))


def _of_left_out(path: str, values: Mapping[str, Any], left_out: set[str]) -> bool:
    """Tell whether a source belongs to a part of the configuration that this run leaves out."""
    keys = path.split(".")
    return keys[0] not in values or ".".join(keys[:2]) in left_out


def _entries(path: str, values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the key paths that a declared one stands for."""
    before, star, _ = path.partition(".*")
    if not star:
        yield path
        return
    yield from (f"{before}.{name}" for name in values.get(before) or {})


def _check(composed: Composed, study: Any) -> None:
    """Check what no record can check alone."""
    with explained(composed):
        for one in registry.experiments().values():
            for check in one.checks:
                check(study)
        check_references(study)
        check_statements(study)


@contextmanager
def explained(composed: Composed) -> Iterator[None]:
    """Put before the message of a check, which begins with its key path, the file or the override that set it."""
    try:
        yield
    except UserError as error:
        message = str(error)
        path = message.split(":")[0].split(" ")[0]
        if path == "override":
            raise
        short = message if len(message) <= _LONGEST else f"{message[:_LONGEST]}..."
        raise UserError(f"{_cause(composed, path)}: {short}") from None


def _cause(composed: Composed, path: str) -> str:
    """Return the overrides below the part that a message is about, which are the likely cause; else the file."""
    section = ".".join(path.split(".")[:2])
    words = [word for word in composed.overrides if word.lstrip("+").startswith(f"{section}.")]
    told = composed.origin(path)
    return f"override {' '.join(words)}" if words and not told.startswith("override") else told
