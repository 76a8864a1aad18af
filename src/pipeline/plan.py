"""The plan: composed runs become nodes with keys, edges, chunks and targets; the one contract with the workflow.

A plan is an immutable JSON file, `results/plan/<digest>.json`. It may hold several runs; nodes with the same key
are the same node, whichever run asked for them.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from pipeline import digest
from pipeline.config.compose import compose_tree
from pipeline.config.study import Study, study_from
from pipeline.draft import Draft, plain
from pipeline.errors import UserError
from pipeline.phases import drafts
from pipeline.planfile import STEPS, TARGETS, VERSION

# Files a step reads beside its inputs, relative to the project; their content is part of the key.
STEP_FILES: dict[str, tuple[str, ...]] = {
    "tuning": ("conf/published/reference/*.csv",),
    "surface": ("conf/published/reference/nicd_*.csv",),
    "network": ("conf/published/reference/nicd_*.csv",),
    "network_size": ("conf/published/reference/nicd_*.csv",),
    "verdicts": ("conf/published/reference/*.csv",),
    "figures": ("src/pipeline/report/*.mplstyle",),
    "page": ("src/pipeline/report/templates/*", "conf/published/reference/*.csv"),
}
# Nodes a job takes at most, in a single run and in a sweep.
CHUNK_SIZE = {
    "panel": (1, 16),
    "supply": (1, 64),
    "tracking": (1, 8),
    "converters": (1, 8),
    "chaos": (1, 8),
    "objective": (1, 32),
    "tuning": (1, 4),
    "search": (1, 8),
    "surface": (1, 8),
    "network": (1, 4),
    "network_size": (1, 4),
    "network_kernels": (1, 4),
    "staging_search": (3, 3),
    "staging": (1, 8),
    "front": (1, 8),
    "function_runs": (2, 2),
    "functions": (1, 8),
    "charge": (4, 12),  # loading the kernels takes as long as a charge or two
    "trade_off": (1, 4),
    "validation": (1, 1),
    "switched": (1, 12),
    "weather": (8, 32),
    "daylight": (8, 32),
    "day": (12, 24),
    "verdicts": (1, 32),
    "figures": (7, 14),
    "page": (1, 8),
}
PUBLISH_SIZE = 32


@dataclass(frozen=True)
class Run:
    """One composed study: its name, its record, its nodes and the key of each.

    `target` names the one target that makes a run which `all` leaves out.
    """

    name: str
    study: Study
    nodes: tuple[Draft, ...]
    keys: Mapping[str, str]
    target: str | None = None


def make_plan(overrides: Iterable[Sequence[str]], asked: Container[str] | None = None) -> dict[str, Any]:
    """Compose one run for each list of overrides and join their nodes into a plan.

    A study run without overrides brings the runs that it has on request.

    Arguments
    ---------
    asked : targets whose runs on request are planned; all of them without.

    Raises
    ------
    UserError : a configuration that does not compose or validate, or two runs of one name.
    """
    runs = [run for words in overrides for run in _runs(words, asked)]
    names = [(run.study.study.name, run.name) for run in runs]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"two runs are named {'/'.join(name)}; give each its own overrides")
    nodes = {key: node for run in runs for key, node in _nodes(run).items()}
    chunks = _chunks(runs, nodes)
    return {
        "version": VERSION,
        "runs": [_described(run) for run in runs],
        "nodes": nodes,
        "chunks": chunks,
        "targets": _targets(runs, chunks),
    }


def run_name(overrides: Sequence[str]) -> str:
    """Return the folder name of a run: its overrides, or `default` where it has none."""
    words = sorted(overrides)
    if not words:
        return "default"
    name = ",".join(words).replace("/", "-").replace(" ", "").replace("'", "").replace('"', "")
    if len(name) > 100:
        name = f"{name[:88]}-{digest.of_value(words)[:8]}"
    return name


def _runs(words: Sequence[str], asked: Container[str] | None) -> Iterator[Run]:
    run = _run(words)
    yield run
    for target, more in run.study.study.on_request.items() if not run.study.overrides else ():
        if asked is None or target in asked:
            yield replace(_run([*words, *more]), target=target)


def _run(words: Sequence[str]) -> Run:
    study = study_from(compose_tree(words))
    nodes = tuple(drafts(study))
    keys: dict[str, str] = {}
    for node in nodes:
        keys[node.name] = digest.of_value(_identity(node, keys), ordered=True)
    return Run(run_name(study.overrides), study, nodes, keys)


def _identity(node: Draft, keys: Mapping[str, str]) -> dict[str, Any]:
    return {
        "step": node.step,
        "settings": node.settings,
        "code": [digest.of_code(module) for module in (f"pipeline.steps.{node.step}", *node.modules)],
        "files": {path.relative_to(digest.PROJECT).as_posix(): digest.of_file(path) for path in step_files(node.step)},
        "inputs": {name: keys[maker] for name, maker in node.inputs.items()},
        "lock": digest.of_lock(),
    }


def step_files(step: str) -> list[Path]:
    """Return the files a step declares that it reads beside its inputs."""
    return sorted(path for pattern in STEP_FILES.get(step, ()) for path in digest.PROJECT.glob(pattern))


def _nodes(run: Run) -> dict[str, dict[str, Any]]:
    return {
        run.keys[node.name]: {
            "step": node.step,
            "settings": node.settings,
            "inputs": {name: run.keys[maker] for name, maker in node.inputs.items()},
        }
        for node in run.nodes
    }


def _described(run: Run) -> dict[str, Any]:
    described = {
        "study": run.study.study.name,
        "name": run.name,
        "overrides": list(run.study.overrides),
        "seed": run.study.seed,
        "configuration": run.study.configuration,
        "sources": plain(run.study.sources),
        "nodes": {node.name: {"step": node.step, "key": run.keys[node.name]} for node in run.nodes},
        "view": [
            {"step": node.step, "key": run.keys[node.name], "file": file, "place": place, "room": node.view}
            for node in run.nodes
            for file, place in node.shown.items()
        ],
    }
    return described | {"digest": digest.of_value(described)}


def _chunks(runs: Sequence[Run], nodes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Group the nodes of each step into jobs, by their order in the plan alone."""
    labels: dict[str, list[str]] = {}
    for run in runs:
        for node in run.nodes:
            labels.setdefault(run.keys[node.name], []).append(node.label)
    chunks: dict[str, dict[str, Any]] = {}
    maker: dict[str, str] = {}
    for step in STEPS:
        alone, in_sweep = CHUNK_SIZE.get(step, (1, 1))
        parts = [
            part
            for keys, sweep in _together(runs)
            for part in _evenly([key for key in keys if nodes[key]["step"] == step], in_sweep if sweep else alone)
        ]
        for part in parts:
            needed = {maker[key] for node in part for key in nodes[node]["inputs"].values()}
            name = _chunk_name([labels[key] for key in part], part)
            chunks[name] = {"step": step, "nodes": part, "needs": sorted(needed)}
            maker.update(dict.fromkeys(part, name))
    for study in dict.fromkeys(run.study.study.name for run in runs):
        own = [place for place, run in enumerate(runs) if run.target is None and run.study.study.name == study]
        for published in ("all", *TARGETS):
            chunks.update(_publications(runs, own, nodes, maker, published))
    for place, run in enumerate(runs):
        if run.target is not None:
            chunks.update(_publications(runs, [place], nodes, maker, "all"))
    return chunks


def _together(runs: Sequence[Run]) -> list[tuple[list[str], bool]]:
    """Return the keys of each study's runs, then those that a run on request has beside them, each with `is a sweep`.

    No job makes nodes of two groups: what is not asked for is not made.
    """
    always = [run for run in runs if run.target is None]
    studies = dict.fromkeys(run.study.study.name for run in always)
    groups = [[run for run in always if run.study.study.name == study] for study in studies]
    groups += [[run] for run in runs if run.target is not None]
    seen: set[str] = set()
    found = []
    for group in groups:
        keys = list(dict.fromkeys(key for run in group for key in run.keys.values() if key not in seen))
        seen.update(keys)
        found.append((keys, len(group) > 1))
    return found


def _evenly(keys: list[str], most: int) -> list[list[str]]:
    """Split keys into as few parts as `most` allows, of nearly the same length."""
    count = -(-len(keys) // most)
    bounds = [round(place * len(keys) / count) for place in range(count + 1)] if count else [0]
    return [keys[start:end] for start, end in pairwise(bounds)]


def _publications(
    runs: Sequence[Run], places: Sequence[int], nodes: Mapping[str, Any], maker: Mapping[str, str], part: str
) -> dict[str, dict[str, Any]]:
    """Return the jobs that link artefacts to their readable places: all of a run's, or a named part of them."""
    steps = TARGETS.get(part, STEPS)
    found = {}
    for start in range(0, len(places), PUBLISH_SIZE):
        numbers = list(places[start : start + PUBLISH_SIZE])
        batch = [runs[number] for number in numbers]
        needed = {maker[key] for run in batch for key in run.keys.values() if nodes[key]["step"] in steps}
        if not needed:
            continue
        labels = [[f"{run.study.study.name}.{run.name}.{part}"] for run in batch]
        name = _chunk_name(labels, [part, *(_described(run)["digest"] for run in batch)])
        found[name] = {"step": "publish", "part": part, "steps": list(steps), "runs": numbers, "needs": sorted(needed)}
    return found


def _chunk_name(labels: Sequence[Sequence[str]], identity: Sequence[str]) -> str:
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
        for part in ("all", *TARGETS)
        if part in parts
    }
    targets["report"] = targets["all"]
    for study in sorted({run.study.study.name for run in runs}):
        mine = {index for index, run in enumerate(runs) if run.study.study.name == study}
        targets[study] = [name for name in targets["all"] if mine & set(published[name]["runs"])]
    for name, target in on_request.items():
        targets.setdefault(target, []).append(name)
    return targets
