"""From a sweep to its plan: each run composed, validated and keyed as far as it differs from those before it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from pipeline.config import naming
from pipeline.config.choices import parse, told
from pipeline.config.compose import Composed, expand
from pipeline.config.effort import check_effort
from pipeline.config.inheritance import CONF, content, file_of, is_group
from pipeline.config.many import Compositions, Memory
from pipeline.config.sections import Recalled, Studies
from pipeline.config.study import study_from
from pipeline.config.units import unit_of
from pipeline.errors import UserError, best_matches
from pipeline.kernel import digest, plan, registry, sweeps
from pipeline.kernel.draft import drafted, paths, plain, reached
from pipeline.kernel.experiment import Draft, Experiment, Node, Swept, kind_of
from pipeline.published.ensemble import EnsembleSettings

Watch = Callable[[Iterable[Any]], Iterable[Any]]
_MOST_REMARKS = 8


@dataclass(frozen=True)
class Asked:
    """What is asked of a sweep.

    Arguments
    ---------
    name : of its folder; without, one is derived from the swept keys.
    keep : kinds of nodes that it makes on demand (`Step.swept_on_demand`), and `traces`.
    job_s : work of a job, at least, by estimate [s]; without, that of the profile.
    words : those of them that say what is made, as they were given; a printed command has them.
    """

    name: str | None = None
    keep: tuple[str, ...] = ()
    job_s: float | None = None
    words: tuple[str, ...] = field(default=(), compare=False)


TRACES = "traces"
DAY_S = 86_400
"""The most work that the jobs of a sweep may be asked to have, each [s]."""
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+=-]{0,99}")


def asked(words: Sequence[str]) -> tuple[list[str], Asked]:
    """Divide the words of a command into Hydra's overrides and what is asked of the sweep itself.

    Raises
    ------
    UserError : another key than `sweep.name`, `sweep.keep` and `sweep.job_s`, or a value that is not allowed there.
    """
    own, given = [], dict[str, Any]()
    for word in words:
        key = word.split("=", 1)[0]
        if key.split(".")[0].lstrip("+") != "sweep":
            own.append(word)
        elif key not in ("sweep.name", "sweep.keep", "sweep.job_s"):
            raise UserError(
                f"override {told(word)}: a sweep has sweep.name=NAME, sweep.keep=[...] and sweep.job_s=SECONDS alone"
            )
        else:
            given[key] = word, parse([word])[0].value()
    word, name = given.get("sweep.name", ("", None))
    if name is not None and not _NAME.fullmatch(str(name)):
        raise UserError(f"override {told(word)}: no good name of a folder; allowed are letters, digits and ._+=-")
    word, keep = given.get("sweep.keep", ("", []))
    keep = keep if isinstance(keep, list) else [keep]
    known = [TRACES, *sorted(_on_demand())]
    for one in keep:
        if one not in known:
            raise UserError(f"override {told(word)}: {one!r} is nothing to keep; {best_matches(str(one), known)}")
    word, job_s = given.get("sweep.job_s", ("", None))
    if job_s is not None and (isinstance(job_s, bool) or not isinstance(job_s, int | float) or not 0 <= job_s <= DAY_S):
        raise UserError(f"override {told(word)}: no work of a job; allowed are seconds from 0 to {DAY_S}")
    said = tuple(str(word) for key, (word, _) in given.items() if key != "sweep.job_s")
    return own, Asked(None if name is None else str(name), tuple(keep), job_s, said)


def make_sweep(words: Sequence[str], asked: Asked, cores: int, watch: Watch = lambda runs: runs) -> dict[str, Any]:
    """Plan a sweep: of every run its charges at nominal parameters and what these need; of all, a table.

    Arguments
    ---------
    words : Hydra's overrides, some with several values.
    cores : jobs at a time.
    watch : goes through the runs, and shows how far it is.

    Raises
    ------
    UserError : a run that does not compose or validate.
    """
    parsed, runs = parse(words), expand(words)
    keys = {place: word.get_key_element().lstrip("+~") for place, word in enumerate(parsed) if word.is_sweep_override()}
    planner = _Planner(asked.keep)
    studies: dict[str, _Gathered] = {}
    for run in watch(runs):
        made = planner.run(run)
        values = {key: planner.value(run[place]) for place, key in keys.items() if key != "study"}
        studies.setdefault(made.study, _Gathered([])).runs.append((run, values, made))
    command = f"python -m pipeline -m {shlex.join([*words, *asked.words])}"
    found = [_sweep(study, gathered, asked, command, planner) for study, gathered in studies.items()]
    return sweeps.make(found, cores, asked.job_s or 0.0)


@dataclass(frozen=True)
class _Made:
    """A run: its study's name, its configuration, the names of its swept nodes -> their keys, what is to be told."""

    study: str
    composed: Composed
    nodes: Mapping[str, str]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class _Gathered:
    """The runs of a study: overrides, values of swept keys, what was planned of each."""

    runs: list[tuple[list[str], dict[str, Any], _Made]]


@dataclass
class _Planner:
    """Plans run after run; nodes and their keys are worked out where something that they read is another one."""

    keep: tuple[str, ...]
    memory: Memory = field(default_factory=Memory)
    nodes: dict[str, Draft] = field(default_factory=dict)
    inputs: dict[str, dict[str, str]] = field(default_factory=dict)
    shown: dict[str, Mapping[str, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._compositions = Compositions(self.memory)
        self._studies = Studies(self.memory)
        experiments = registry.experiments()
        owners = {registry.owners()[step] for step in _needed_steps()}
        self._makers = {name: Recalled(_listed(experiments[name].nodes)) for name in sorted(owners)}
        self._alone = {name: Recalled(one.alone) for name, one in experiments.items()}
        self._remarks: dict[frozenset[str], list[Recalled]] = {}
        self._drafts: dict[Any, tuple[Any, Draft]] = {}
        self._keys: dict[Any, str] = {}
        self._fixed: dict[Any, dict[str, Any]] = {}

    def value(self, word: str) -> Any:
        """Return what an override sets."""
        return self._compositions.value(word)

    def run(self, words: Sequence[str]) -> _Made:
        """Plan one run."""
        composed = self._compositions.compose(words)
        study = self._studies.of(composed)
        alone = {name for name, asks in self._alone.items() if asks(study)}
        makers = [make for name, make in self._makers.items() if name in alone or not alone]
        # No shares over ranges are made of a run of a sweep.
        bare = study.model_copy(update={"ensemble": _NO_SHARES})
        by_name = {node.name: node for make in makers for node in make(bare)}
        kept = list(self._kept([node for node in by_name.values() if node.step.swept], composed))
        if not kept:
            raise UserError(f"study {study.study.name}: nothing of it is swept; run it by itself, without -m")
        drafts: dict[str, Draft] = {}
        keys: dict[str, str] = {}
        for node in kept:
            self.shown[node.name] = dict(node.shown)
            self._key(node.name, by_name, study, drafts, keys)
        check_effort(composed, study, list(drafts.values()))
        kinds = frozenset(draft.kind for draft in drafts.values())
        remarks = tuple(line for told_of in self._told(kinds) for line in told_of(study))
        return _Made(study.study.name, composed, {node.name: keys[node.name] for node in kept}, remarks)

    def _kept(self, nodes: Sequence[Node], composed: Composed) -> Iterator[Node]:
        """Yield the nodes without those on demand that are neither asked for nor overridden in what is theirs alone."""
        asked_for = {node.name: kind_of(node.name) not in {*node.step.swept_on_demand} - {*self.keep} for node in nodes}
        usual = {path for node in nodes if asked_for[node.name] for path in _read(node)}
        for node in nodes:
            own = () if asked_for[node.name] else {*_read(node)} - usual
            if asked_for[node.name] or any(composed.touched(path) or composed.overridden(path) for path in own):
                yield node

    def _told(self, kinds: frozenset[str]) -> list[Recalled]:
        """Return what makes the remarks on a run with nodes of some kinds."""
        if kinds not in self._remarks:
            experiments = registry.experiments().values()
            self._remarks[kinds] = [Recalled(_listed(partial(_remarks, one, kinds))) for one in experiments]
        return self._remarks[kinds]

    def _key(
        self, name: str, by_name: Mapping[str, Node], study: Any, drafts: dict[str, Draft], keys: dict[str, str]
    ) -> str:
        """Return the key of a node; it and all that it takes from are noted."""
        if name in keys:
            return keys[name]
        draft = self._draft(by_name[name], study)
        for maker in draft.inputs.values():
            self._key(maker, by_name, study, drafts, keys)
        drafts[name] = draft
        identity = (id(draft), tuple(keys[maker] for maker in draft.inputs.values()))
        if identity not in self._keys:
            of = (draft.step, draft.modules)
            if of not in self._fixed:
                self._fixed[of] = plan.fixed(draft)
            key = plan.key_of(draft, keys, self._fixed[of])
            self._keys[identity] = key
            self.nodes.setdefault(key, draft)
            self.inputs.setdefault(key, {one: keys[maker] for one, maker in draft.inputs.items()})
        keys[name] = self._keys[identity]
        return keys[name]

    def _draft(self, node: Node, study: Any) -> Draft:
        """Return a node with its settings; the same one while all that it declares to read is the same."""
        reads = [_at(study, path) for path in _read(node)]
        which = (node.step.name, node.name, repr(node.which), repr(node.inputs), node.modules)
        identity = (which, tuple(id(value) for value in reads))
        if identity not in self._drafts:
            self._drafts[identity] = reads, drafted(node, study)
        return self._drafts[identity][1]


_NO_SHARES = EnsembleSettings(points=0)


def _listed(function: Callable[[Any], Iterable[Any]]) -> Callable[[Any], tuple[Any, ...]]:
    return lambda study: tuple(function(study))


def _remarks(experiment: Experiment, kinds: Collection[str], study: Any) -> Iterable[str]:
    return experiment.remarks(study, kinds)


def _read(node: Node) -> Iterator[str]:
    return (path for read in node.step.reads for path in paths(read, node.which))


def _on_demand() -> set[str]:
    """Return the kinds of nodes that a sweep has only where they are asked for."""
    return {kind for step in registry.steps().values() for kind in step.swept_on_demand}


def _needed_steps() -> set[str]:
    """Return the swept steps and all that they may take from."""
    return reached((name for name, step in registry.steps().items() if step.swept), registry.takes)


def _at(study: Any, path: str) -> Any:
    here = study
    for key in path.split("."):
        here = here.get(key) if isinstance(here, Mapping) else getattr(here, key, None)
    return here


def _sweep(study: str, gathered: _Gathered, asked: Asked, command: str, planner: _Planner) -> sweeps.Sweep:
    """Return the runs of a study with what is made of all of them."""
    words, values, first = gathered.runs[0]
    root = study_from(first.composed)
    keys = list(values)
    short = naming.short(keys, first.composed.tree)
    runs = []
    for words, values, made in gathered.runs:
        texts = [f"{short[key]}={_text(value)}" for key, value in values.items()]
        name = naming.joined(texts, words) if texts else "default"
        own = tuple(word for word in words if not word.startswith("study="))
        runs.append(sweeps.SweepRun(name, own, tuple(values.values()), made.nodes))
    _check_names(study, runs)
    name = asked.name or _derived(short.values(), [run.overrides for run in runs])
    columns = [
        {
            "key": key,
            "short": short[key],
            "unit": _unit(root, key, [run.values[n] for run in runs]),
            "description": f"swept: {key}",
            "titles": _titles(key, [run.values[n] for run in runs]),
        }
        for n, key in enumerate(keys)
    ]
    remarks = list(dict.fromkeys(line for _, _, made in gathered.runs for line in made.remarks))
    if len(remarks) > _MOST_REMARKS:
        remarks[_MOST_REMARKS:] = [f"and {len(remarks) - _MOST_REMARKS} more such notes on other runs"]
    used = {key for run in runs for key in run.keys.values()}
    nodes = reached(used, lambda key: planner.inputs[key].values())
    return sweeps.Sweep(
        study=study,
        name=name,
        command=command,
        seed=root.seed,
        configuration=root.configuration,
        sources=plain(root.sources),
        runs=tuple(runs),
        nodes={key: planner.nodes[key] for key in planner.nodes if key in nodes},
        inputs={key: planner.inputs[key] for key in nodes},
        closing=_closing(study, name, command, root, columns, runs),
        shown=planner.shown if TRACES in asked.keep else {},
        remarks=tuple(remarks),
    )


def _titles(key: str, values: Sequence[Any]) -> dict[str, str]:
    """Return the titles of the options of a group that a sweep goes over; none for any other key."""
    group = key.partition("@")[0]
    if not is_group(CONF, group):
        return {}
    cards = {value: content(file_of(CONF, f"{group}/{value}.yaml")) for value in map(str, values)}
    return {value: str(card["title"]) for value, card in cards.items() if "title" in card}


def _closing(
    study: str,
    name: str,
    command: str,
    root: Any,
    columns: Sequence[Mapping[str, Any]],
    runs: Sequence[sweeps.SweepRun],
) -> tuple[Draft, ...]:
    """Return what the experiments make of all runs."""
    listed = tuple(
        {"name": run.name, "values": list(run.values), "nodes": {node: f"{run.name}/{node}" for node in run.keys}}
        for run in runs
    )
    swept = Swept(root, name, command, f"results/{study}/{sweeps.FOLDER}/{name}", tuple(columns), listed)
    makers = (one.gathers for one in registry.experiments().values())
    return tuple(draft for gather in makers if gather is not None for draft in gather(swept))


def _check_names(study: str, runs: Sequence[sweeps.SweepRun]) -> None:
    seen: dict[str, sweeps.SweepRun] = {}
    for run in runs:
        if run.name in seen:
            words = " ".join(map(told, run.overrides))
            raise UserError(f"two runs of {study} are named {run.name}; give each its own values: {words}")
        seen[run.name] = run


def _derived(short: Iterable[str], overrides: Sequence[Sequence[str]]) -> str:
    """Return the name of a sweep that has none: its swept keys, and six digits of all its runs."""
    name = naming.joined(list(short) or ["study"], ["sweep"])
    return f"{name[:60]}-{digest.of_value([list(one) for one in overrides])[:6]}"


def _text(value: Any) -> str:
    if isinstance(value, list):
        return f"[{','.join(map(_text, value))}]"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return str(value)


def _unit(root: Any, key: str, values: Sequence[Any]) -> str:
    """Return the unit of a swept key; none of what is text."""
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return ""
    return unit_of(root, key)
