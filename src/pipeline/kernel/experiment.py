"""What an experiment declares: all that the kernel, the configuration and the report know of it.

An experiment is a package in `pipeline/experiments`; it exports one `EXPERIMENT` and is found by its folder.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from pipeline.kernel.tables import TableFile

FOUND = "found values"
"""Stands in `takes` for every step that finds values which a configuration may ask for."""
EVERYTHING = "every step"
"""Stands in `takes` for every step of the other experiments."""


def kind_of(name: str) -> str:
    """Return the kind of a node: the first word of its name."""
    return name.split("/")[0]


class Vocabulary(Protocol):
    """The numbers that a step finds: their names, perhaps with fields in braces, their units and meanings."""

    def names(self, fields: Mapping[str, Iterable[object]]) -> set[str]:
        """Return every name, for the values that the fields may take."""


class Effort(NamedTuple):
    """What a node is likely to take, within a factor of a few.

    `memory_b` is that of the step at its most [B], `time_s` that of one core [s]; `grows_with` are the key paths of the
    configuration that it grows with, the steepest first.
    """

    memory_b: float
    time_s: float
    grows_with: tuple[str, ...]


def _nothing(config: Any, **which: Any) -> dict[str, Any]:
    return {}


@dataclass(frozen=True)
class Step:
    """A step of the pipeline.

    Arguments
    ---------
    name : its name; the module of this name in the experiment's package has `run(settings, inputs, output)`.
    rule, message : the rule of the workflow that runs it, and what it prints; `{chunk}` is the job.
    settings : `(config, **which)` -> the settings of a node, as plain data or records; sees only what `reads` names.
    reads : key paths of the configuration that enter its settings. `{mode}` stands for what a node says of itself
        under `mode` in `which`: a word, several, or none. These are also the provenance of what it makes.
    takes : steps whose artefacts it reads.
    tables : the tables that it writes, by name.
    usual_table : the one that a statement means where it names none.
    quantities : the named numbers in its tables.
    target : the target that publishes it beside `all`.
    chunk : nodes of a job, at most: in a single run, and in a sweep.
    priority : of its jobs among those that could start; the longest go first.
    files : patterns of files of the project that it reads beside its inputs; their content is part of its key.
    effort : `(config, **which)` -> what a node is likely to take, where that can grow with the configuration.
    finds : whether it writes values that a configuration asks for with `{from: step, value: name}`.
    on_demand : whether it runs only where something asks for what it makes.
    needed_by_figures : whether a figure that reads it is left out where it is not made.
    shown : whether the page reads its artefacts.
    swept : whether each run of a sweep has its nodes; those of other steps only where these take from them.
    swept_on_demand : kinds of its nodes that a sweep has only where `sweep.keep` or an override asks for them.
    """

    name: str
    rule: str
    message: str
    settings: Callable[..., Mapping[str, Any]] = _nothing
    reads: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    tables: Mapping[str, TableFile] = field(default_factory=dict)
    usual_table: str | None = None
    quantities: Vocabulary | None = None
    target: str | None = None
    chunk: tuple[int, int] = (1, 1)
    priority: int = 0
    files: tuple[str, ...] = ()
    effort: Callable[..., Effort] | None = None
    finds: bool = False
    on_demand: bool = False
    needed_by_figures: bool = False
    shown: bool = True
    swept: bool = False
    swept_on_demand: tuple[str, ...] = ()

    def places(self, room: str, *without: str) -> dict[str, str]:
        """Return file -> place below a folder of the readable view, for every table of a fixed name."""
        files = (one.file for name, one in self.tables.items() if "{" not in one.file and name not in without)
        return {file: f"{room}/{file}" for file in files}


@dataclass(frozen=True)
class Node:
    """Something that a step is to make for a run.

    Arguments
    ---------
    step : the step.
    name : unique in a run; its first word is the node's kind, which is the step's name unless said otherwise.
    label : what its job is called.
    which : what tells the node from others of its step; handed to the step's `settings`, and put into its `reads`.
    inputs : name under which the step finds an input -> name of the node that makes it.
    shown : file of the artefact (`*`: all of them, names kept) -> its place in the readable view.
    room : the readable view it is shown in, `results` or `reports`.
    modules : modules that the step imports by a name that stands in its settings.
    """

    step: Step
    name: str
    label: str
    which: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, str] = field(default_factory=dict)
    shown: Mapping[str, str] = field(default_factory=dict)
    room: str = "results"
    modules: tuple[str, ...] = ()


@dataclass(frozen=True)
class Draft:
    """A node before it has a key.

    `settings` is plain data; `reads` are the key paths of the configuration behind it, its provenance; the rest is
    that of `Node`. `effort` is outside its key.
    """

    step: str
    name: str
    label: str
    settings: dict[str, Any]
    inputs: dict[str, str]
    reads: tuple[str, ...]
    shown: dict[str, str]
    room: str
    modules: tuple[str, ...]
    effort: Effort | None = None

    @property
    def kind(self) -> str:
        """Return the first word of its name."""
        return kind_of(self.name)


@dataclass(frozen=True)
class Label:
    """A part of the configuration as figures and the page show it.

    Arguments
    ---------
    make : `(config)` -> plain data; sees only what `reads` names.
    reads : key paths of the configuration.
    """

    make: Callable[[Any], Mapping[str, Any]]
    reads: tuple[str, ...]


@dataclass(frozen=True)
class Swept:
    """The runs of a sweep, as an experiment that makes something of all of them is told.

    Arguments
    ---------
    study : the root record of the first run.
    name, command : of the sweep, and what a person typed.
    folder : of its readable view, from the project.
    keys : of every swept key its path, short name, unit, description, and titles of the options of a group.
    runs : of every run its name, the values of the swept keys, and name -> artefact of its swept nodes.
    """

    study: Any
    name: str
    command: str
    folder: str
    keys: tuple[Mapping[str, Any], ...]
    runs: tuple[Mapping[str, Any], ...]


def _no_nodes(study: Any) -> Iterable[Node]:
    return ()


def _no_remarks(study: Any, kinds: Collection[str]) -> Iterable[str]:
    return ()


def _never(study: Any) -> bool:
    return False


def _no_names(study: Any) -> Mapping[str, Any]:
    return {}


@dataclass(frozen=True)
class Experiment:
    """All that the project says about a capability.

    Arguments
    ---------
    title : what it is about, in a few words.
    steps : its steps.
    nodes : study -> the nodes that it has of these steps.
    part : record with its part of the configuration; its fields become fields of the root record.
    parameters : key paths below which every number has a source; `*` stands for every entry of a mapping.
    refers : key path of a word, or of a list of words -> the mapping of the configuration of which it names an entry.
        Entries that nothing names are left out of the configuration.
    written : field of the part -> another record as which it may be written; `prepare` makes the field's own of it.
    prepare : (composed, values, written sources) -> values, before they are validated.
    remarks : (study, kinds of the nodes that are made) -> sentences for whoever plans it, each beginning with a key
        path; nothing is refused.
    checks : study -> nothing; raises `UserError`, its message beginning with a key path, for what no record can check.
    finds : study -> step -> names of the values that it finds.
    inputs : study -> names of the artefacts that statements may read, also with modes that a run leaves out.
    fields : study -> step -> field in the names of its quantities -> the values it may take; no step: not checked.
    labels : name -> part of the configuration that figures and pages show.
    alone : study -> whether it has these nodes and no others.
    closing : (study, every other node) -> nodes that depend on what the others are.
    gathers : the runs of a sweep -> what is made of all of them, each from the artefacts of the runs and from those
        before it.
    tells : module of the package whose `lines(run, results)` says at the end what a person should know.
    announces : module of the package whose `published(run, manifest, results)` is called when a run was published.
    """

    title: str
    steps: tuple[Step, ...]
    nodes: Callable[[Any], Iterable[Node]] = _no_nodes
    part: type | None = None
    parameters: tuple[str, ...] = ()
    refers: Mapping[str, str] = field(default_factory=dict)
    written: Mapping[str, type] = field(default_factory=dict)
    prepare: Callable[[Any, dict[str, Any], dict[str, Any]], dict[str, Any]] | None = None
    checks: tuple[Callable[[Any], None], ...] = ()
    remarks: Callable[[Any, Collection[str]], Iterable[str]] = _no_remarks
    finds: Callable[[Any], Mapping[str, tuple[str, ...]]] = _no_names
    inputs: Callable[[Any], Iterable[str]] = _no_nodes  # type: ignore[assignment]
    fields: Callable[[Any], Mapping[str, Mapping[str, Iterable[object]]]] = _no_names
    labels: Mapping[str, Label] = field(default_factory=dict)
    alone: Callable[[Any], bool] = _never
    closing: Callable[[Any, Sequence[Draft]], Iterable[Node]] | None = None
    gathers: Callable[[Swept], Iterable[Draft]] | None = None
    tells: str | None = None
    announces: str | None = None
