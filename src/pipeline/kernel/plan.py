"""The plan: composed runs become nodes with keys, edges, chunks and targets; the one contract with the workflow.

A plan is an immutable JSON file, `results/plan/<digest>.json`. It may hold several runs; nodes with the same key
are the same node, whichever run asked for them.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from pipeline.kernel import digest, footprint, places, registry
from pipeline.kernel.code import of_code
from pipeline.kernel.draft import behind
from pipeline.kernel.errors import UserError
from pipeline.kernel.experiment import Draft, Effort
from pipeline.kernel.planfile import VERSION

PUBLISH_SIZE = 32
PUBLISHING = footprint.Footprint(memory_mb=100.0, start_s=1.0, node_s=2.0)
_CODE = "src/pipeline/"
PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"
"""What of the interpreter's version is part of every key."""
_BESIDE_FIGURES = ("index.html", "card.json", "traces.js")
# What every step goes through: a table that is written otherwise is another artefact.
_COMMON = ("pipeline.kernel.artefacts",)


@dataclass(frozen=True)
class Run:
    """A composed study and its nodes.

    Arguments
    ---------
    study, name : of the study and of the run, which are also its folders.
    overrides : words that make it another run than the study's own.
    seed : root of its random streams.
    configuration, sources : as composed, plain data.
    nodes : inputs before those that read them.
    target : the one target that makes a run which `all` leaves out.
    remarks : what whoever planned it was told.
    """

    study: str
    name: str
    overrides: tuple[str, ...]
    seed: int
    configuration: Mapping[str, Any]
    sources: Mapping[str, Any]
    nodes: tuple[Draft, ...]
    target: str | None = None
    remarks: tuple[str, ...] = ()
    keys: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for node in self.nodes:
            self.keys[node.name] = key_of(node, self.keys, fixed(node))

    def described(self) -> dict[str, Any]:
        """Return the run as the plan holds it."""
        found = {
            "study": self.study,
            "name": self.name,
            "overrides": list(self.overrides),
            "seed": self.seed,
            "configuration": self.configuration,
            "sources": self.sources,
            "remarks": list(self.remarks),
            "nodes": {node.name: {"step": node.step, "key": self.keys[node.name]} for node in self.nodes},
            "view": [
                {"step": node.step, "key": self.keys[node.name], "file": file, "place": place, "room": node.room}
                for node in self.nodes
                for file, place in node.shown.items()
            ],
        }
        return found | {"digest": digest.of_value(found)}


def make(runs: Sequence[Run], asked: Collection[str] = ()) -> dict[str, Any]:
    """Join runs into a plan.

    Arguments
    ---------
    asked : words of the command line; files of the readable views among them get jobs of their own. Where nothing
        else is asked for, nothing else is planned.

    Raises
    ------
    UserError : two runs of one name, or a file that no run makes.
    """
    names = [(run.study, run.name) for run in runs]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"two runs are named {'/'.join(name)}; give each its own overrides")
    described = [run.described() for run in runs]
    files = _files(runs, described, asked)
    parts = {"all", "report", *registry.targets(), *(run.target for run in runs), *(run.study for run in runs)}
    alone = bool(files) and not parts & set(asked)
    wanted = {node for file in files.values() for node in file["nodes"]} if alone else None
    nodes = {key: node for run in runs for key, node in _nodes(run).items() if wanted is None or key in wanted}
    chunks, targets = _jobs(runs, described, nodes, published=not alone)
    for path, file in files.items():
        maker = {key: name for name, chunk in chunks.items() for key in chunk.get("nodes", ())}
        chunk = chunk_name([[Path(path).name]], [path, described[file["run"]]["digest"]])
        chunks[chunk] = publishing(path, [], [file["run"]], [maker[file["key"]]])
        targets[path] = [chunk]
    return {
        "version": VERSION,
        "runs": described,
        "steps": {name: declared(name) for name in registry.steps()},
        "nodes": nodes,
        "chunks": chunks,
        "targets": targets,
        "tells": modules_named("tells"),
        "announces": modules_named("announces"),
    }


def modules_named(field_name: str) -> list[str]:
    """Return the modules that experiments name in a field, by their dotted names."""
    named = {name: getattr(one, field_name) for name, one in registry.experiments().items()}
    return sorted(f"{registry.PACKAGE}.{name}.{module}" for name, module in named.items() if module)


def step_files(step: str) -> dict[str, Path]:
    """Return the files a step declares that it reads beside its inputs, by their names in the project."""
    found: dict[str, Path] = {}
    for pattern in registry.steps()[step].files:
        code = pattern.removeprefix(_CODE)
        roots = [("", places.SHIPPED), ("", places.PROJECT)] if code == pattern else [(_CODE, places.PACKAGE)]
        for prefix, root in roots:
            found |= {prefix + path.relative_to(root).as_posix(): path for path in root.glob(code)}
    return dict(sorted(found.items()))


def declared(name: str) -> dict[str, Any]:
    """Return what the jobs and the rules of a step need of its declaration."""
    step = registry.steps()[name]
    return {
        "module": registry.module(name),
        "rule": step.rule,
        "message": step.message,
        "target": step.target,
        "priority": step.priority,
        "tables": {table: found.plain() for table, found in step.tables.items()},
    }


def fixed(node: Draft) -> dict[str, Any]:
    """Return what of a node's key does not depend on the configuration: code, declared tables, files, versions."""
    modules = (registry.module(node.step), *_COMMON, *node.modules)
    return {
        "code": [_code(module) for module in modules],
        "tables": digest.of_value({name: one.plain() for name, one in registry.steps()[node.step].tables.items()}),
        "files": {name: digest.of_file(path) for name, path in step_files(node.step).items()},
        "lock": digest.of_lock(),
        "python": PYTHON,
    }


_code = cache(of_code)


def key_of(node: Draft, keys: Mapping[str, str], fixed: Mapping[str, Any]) -> str:
    """Return the key of a node.

    Arguments
    ---------
    keys : name of each node that it takes from -> its key.
    fixed : what `fixed` says of it.
    """
    identity = {
        "step": node.step,
        "settings": node.settings,
        "code": fixed["code"],
        "tables": fixed["tables"],
        "files": fixed["files"],
        "inputs": {name: keys[maker] for name, maker in node.inputs.items()},
        "lock": fixed["lock"],
        "python": fixed["python"],
    }
    return digest.of_value(identity, ordered=True)


def _nodes(run: Run) -> dict[str, dict[str, Any]]:
    return {
        run.keys[node.name]: {
            "step": node.step,
            "settings": node.settings,
            "inputs": {name: run.keys[maker] for name, maker in node.inputs.items()},
        }
        for node in run.nodes
    }


def _files(runs: Sequence[Run], described: Sequence[Mapping[str, Any]], asked: Collection[str]) -> dict[str, Any]:
    """Return the files of the readable views among the words asked for -> run, key, and every node behind it."""
    found: dict[str, Any] = {}
    for path in (word for word in asked if word.split("/")[0] in ("results", "reports") and word.count("/") > 2):
        room, study, name, place = path.split("/", 3)
        for number, run in enumerate(runs):
            if (run.study, run.name) != (study, name):
                continue
            shown = [one for one in described[number]["view"] if one["room"] == room and _shows(one, place)]
            if shown:
                by_name = {node.name: node for node in run.nodes}
                makers = [node.name for node in run.nodes if run.keys[node.name] == shown[0]["key"]]
                nodes = {run.keys[node] for node in behind(by_name, makers)}
                found[path] = {"run": number, "key": shown[0]["key"], "nodes": nodes}
        if path not in found:
            raise UserError(f"{path}: no run that is planned makes this file")
    return found


def _shows(item: Mapping[str, Any], place: str) -> bool:
    """Tell whether an entry of a run's view stands for a place in it; `*` is all that a page is made of."""
    if item["file"] != "*":
        return bool(item["place"] == place)
    alone = {f"{item['place']}{file}" for file in _BESIDE_FIGURES}
    return place in alone or place.startswith(f"{item['place']}tables/")


def _jobs(
    runs: Sequence[Run], described: Sequence[Mapping[str, Any]], nodes: Mapping[str, Any], published: bool
) -> tuple[dict[str, dict[str, Any]], dict[str, list[str]]]:
    """Group the nodes of each step into jobs, by their order in the plan alone; then the jobs that publish them."""
    labels: dict[str, list[str]] = {}
    efforts: dict[str, Effort | None] = {}
    for run in runs:
        for node in run.nodes:
            labels.setdefault(run.keys[node.name], []).append(node.label)
            efforts[run.keys[node.name]] = node.effort
    chunks: dict[str, dict[str, Any]] = {}
    maker: dict[str, str] = {}
    groups = [([key for key in keys if key in nodes], sweep) for keys, sweep in _together(runs)]
    for step in registry.steps().values():
        alone, in_sweep = step.chunk
        for keys, sweep in groups:
            own = [key for key in keys if nodes[key]["step"] == step.name]
            for batch in evenly(own, in_sweep if sweep else alone):
                needs = {maker[key] for node in batch for key in nodes[node]["inputs"].values()}
                name = chunk_name([labels[key] for key in batch], batch)
                resources = footprint.resources(footprint.of_step(step), [efforts[key] for key in batch])
                chunks[name] = {"step": step.name, "nodes": batch, "needs": sorted(needs), "resources": resources}
                maker.update(dict.fromkeys(batch, name))
    if not published:
        return chunks, {}
    publishing = _Publishing(runs, described, nodes, maker)
    for study in dict.fromkeys(run.study for run in runs):
        own_runs = [place for place, run in enumerate(runs) if run.target is None and run.study == study]
        for part in ("all", *registry.targets()):
            chunks.update(publishing.jobs(own_runs, part))
    for place, run in enumerate(runs):
        if run.target is not None:
            chunks.update(publishing.jobs([place], "all"))
    return chunks, _targets(runs, chunks)


def _together(runs: Sequence[Run]) -> list[tuple[list[str], bool]]:
    """Return the keys of each study's runs, then those that a run on request has beside them, each with `is a sweep`.

    No job makes nodes of two groups: what is not asked for is not made.
    """
    always = [run for run in runs if run.target is None]
    studies = dict.fromkeys(run.study for run in always)
    groups = [[run for run in always if run.study == study] for study in studies]
    groups += [[run] for run in runs if run.target is not None]
    seen: set[str] = set()
    found = []
    for group in groups:
        keys = list(dict.fromkeys(key for run in group for key in run.keys.values() if key not in seen))
        seen.update(keys)
        found.append((keys, len(group) > 1))
    return found


def evenly(keys: list[str], most: int) -> list[list[str]]:
    """Split keys into as few parts as `most` allows, of nearly the same length."""
    count = -(-len(keys) // most)
    bounds = [round(place * len(keys) / count) for place in range(count + 1)] if count else [0]
    return [keys[start:end] for start, end in pairwise(bounds)]


@dataclass(frozen=True)
class _Publishing:
    """The jobs that link artefacts to their readable places."""

    runs: Sequence[Run]
    described: Sequence[Mapping[str, Any]]
    nodes: Mapping[str, Any]
    maker: Mapping[str, str]

    def jobs(self, places: Sequence[int], part: str) -> dict[str, dict[str, Any]]:
        """Return those of some runs: all of a run, or a named part of it."""
        steps = registry.targets().get(part, tuple(registry.steps()))
        found = {}
        for start in range(0, len(places), PUBLISH_SIZE):
            numbers = list(places[start : start + PUBLISH_SIZE])
            batch = [self.runs[number] for number in numbers]
            keys = {key for run in batch for key in run.keys.values() if self.nodes[key]["step"] in steps}
            if not keys:
                continue
            labels = [[f"{run.study}.{run.name}.{part}"] for run in batch]
            name = chunk_name(labels, [part, *(self.described[number]["digest"] for number in numbers)])
            needed = sorted({self.maker[key] for key in keys})
            found[name] = publishing(part, steps, numbers, needed)
        return found


def publishing(part: str, steps: Iterable[str], runs: Sequence[int], needs: Sequence[str]) -> dict[str, Any]:
    """Return a job that shows what some steps made for some runs, as the plan holds it."""
    found = {"step": "publish", "part": part, "steps": list(steps), "runs": list(runs), "needs": list(needs)}
    return found | {"resources": footprint.resources(PUBLISHING, [None])}


def chunk_name(labels: Sequence[Sequence[str]], identity: Sequence[str]) -> str:
    """Return a readable name: what the first node is, how many more there are, and six digits of their keys."""
    first = labels[0]
    label = first[0] if len(set(first)) == 1 else first[0].rsplit(".", 1)[-1]
    label = "".join(letter if letter.isalnum() or letter in "._-" else "_" for letter in label)[:60]
    more = f"+{len(labels) - 1}" if len(labels) > 1 else ""
    return f"{label}{more}-{digest.of_value(list(identity))[:6]}"


def _targets(runs: Sequence[Run], chunks: Mapping[str, Any]) -> dict[str, list[str]]:
    requested = {place: run.target for place, run in enumerate(runs) if run.target is not None}
    on_request = {
        name: requested[chunk["runs"][0]]
        for name, chunk in chunks.items()
        if chunk["step"] == "publish" and chunk["runs"][0] in requested
    }
    published = {name: chunk for name, chunk in chunks.items() if chunk["step"] == "publish" and name not in on_request}
    parts = {chunk["part"] for chunk in published.values()}
    targets = {
        part: [name for name, chunk in published.items() if chunk["part"] == part]
        for part in ("all", *registry.targets())
        if part in parts
    }
    targets["report"] = targets["all"]
    for study in sorted({run.study for run in runs}):
        mine = {index for index, run in enumerate(runs) if run.study == study}
        targets[study] = [name for name in targets["all"] if mine & set(published[name]["runs"])]
    for name, target in on_request.items():
        targets.setdefault(str(target), []).append(name)
    return targets
