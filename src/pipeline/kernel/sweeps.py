"""The plan of a sweep: what its runs have in common once, each run as what makes it another one.

To the workflow a sweep is one run of its study, with the nodes of all its runs, whose table and page it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any

from pipeline.kernel import digest, footprint, plan, registry
from pipeline.kernel.experiment import Draft, Effort, Step
from pipeline.kernel.planfile import VERSION

FOLDER = "sweeps"
"""Folder of a study's sweeps, beside its runs."""
_MOST = 512
"""Nodes of a swept step in a job, at most: to read the plan and to load the kernels is little beside them."""


@dataclass(frozen=True)
class SweepRun:
    """A run of a sweep: its name, its overrides, the values of the swept keys, name -> key of its swept nodes."""

    name: str
    overrides: tuple[str, ...]
    values: tuple[Any, ...]
    keys: Mapping[str, str]


@dataclass(frozen=True)
class Sweep:
    """The runs that a sweep has of one study.

    Arguments
    ---------
    study, name : of the study and of the sweep.
    command : what a person typed.
    seed, configuration, sources : of the first run.
    runs : the runs.
    nodes : key -> node, inputs before those that read them.
    inputs : key of a node -> name of each input -> key of the node that makes it.
    closing : nodes made from those of all runs; each takes all that the runs have, and the closing ones before it.
    shown : name of a run's node -> file of its artefact -> its place in the run's folder of the readable view.
    remarks : what whoever planned it was told.
    """

    study: str
    name: str
    command: str
    seed: int
    configuration: Mapping[str, Any]
    sources: Mapping[str, Any]
    runs: tuple[SweepRun, ...]
    nodes: Mapping[str, Draft]
    inputs: Mapping[str, Mapping[str, str]]
    closing: tuple[Draft, ...]
    shown: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


def make(sweeps: Sequence[Sweep], cores: int, job_s: float = 0.0) -> dict[str, Any]:
    """Join the sweeps of several studies into a plan.

    Arguments
    ---------
    cores : jobs at a time; twice as many jobs at least share the nodes of a swept step.
    job_s : work of a job, at least, by estimate, where there are nodes enough: it goes before the number of jobs [s].
    """
    parts = _Parts()
    nodes: dict[str, dict[str, Any]] = {}
    labels: dict[str, str] = {}
    efforts = {key: node.effort for sweep in sweeps for key, node in sweep.nodes.items()}
    described = []
    for sweep in sweeps:
        for key, node in sweep.nodes.items():
            nodes[key] = {"step": node.step, "parts": parts.of(node.settings), "inputs": dict(sweep.inputs[key])}
            labels[key] = node.label
        described.append(_described(sweep, nodes, labels, efforts))
    chunks, targets = _jobs(described, nodes, labels, efforts, cores, job_s)
    return {
        "version": VERSION,
        "runs": described,
        "steps": {name: plan.declared(name) for name in registry.steps()},
        "parts": parts.kept,
        "nodes": nodes,
        "chunks": chunks,
        "targets": targets,
        "tells": plan.modules_named("tells"),
        "announces": plan.modules_named("announces"),
    }


class _Parts:
    """Parts of settings, each kept once under the digest of its value."""

    def __init__(self) -> None:
        self.kept: dict[str, Any] = {}

    def of(self, settings: Mapping[str, Any]) -> dict[str, str]:
        """Return the digests under which the parts of some settings are kept."""
        found = {}
        for name, value in settings.items():
            # The order of keys has a meaning in some.
            found[name] = digest.of_value(value, ordered=True)[:20]
            self.kept.setdefault(found[name], value)
        return found


def _described(
    sweep: Sweep, nodes: dict[str, dict[str, Any]], labels: dict[str, str], efforts: dict[str, Effort | None]
) -> dict[str, Any]:
    """Return a sweep as the plan holds it, as a run; its closing nodes are put to the others."""
    keys = {f"{run.name}/{name}": key for run in sweep.runs for name, key in run.keys.items()}
    view = [
        {"step": nodes[key]["step"], "key": key, "file": file, "place": f"{run.name}/{place}", "room": "results"}
        for run in sweep.runs
        for name, key in run.keys.items()
        for file, place in sweep.shown.get(name, {}).items()
    ]
    for node in sweep.closing:
        key = plan.key_of(node, keys, plan.fixed(node))
        inputs = {name: keys[maker] for name, maker in node.inputs.items()}
        nodes[key] = {"step": node.step, "settings": node.settings, "inputs": inputs}
        labels[key], efforts[key] = node.label, node.effort
        keys[node.name] = key
        view += [
            {"step": node.step, "key": key, "file": file, "place": place, "room": node.room}
            for file, place in node.shown.items()
        ]
    found = {
        "study": sweep.study,
        "name": f"{FOLDER}/{sweep.name}",
        "overrides": [],
        "command": sweep.command,
        "seed": sweep.seed,
        "configuration": sweep.configuration,
        "sources": sweep.sources,
        "remarks": list(sweep.remarks),
        "nodes": {name: {"step": nodes[key]["step"], "key": key} for name, key in keys.items()}
        | {f"{nodes[key]['step']}/{key[:12]}": {"step": nodes[key]["step"], "key": key} for key in sweep.nodes},
        "view": view,
        "sweep": {
            run.name: {"overrides": list(run.overrides), "values": list(run.values), "nodes": len(run.keys)}
            for run in sweep.runs
        },
    }
    return found | {"digest": digest.of_value(found)}


def _jobs(
    described: Sequence[Mapping[str, Any]],
    nodes: Mapping[str, Mapping[str, Any]],
    labels: Mapping[str, str],
    efforts: Mapping[str, Effort | None],
    cores: int,
    job_s: float,
) -> tuple[dict[str, dict[str, Any]], dict[str, list[str]]]:
    chunks: dict[str, dict[str, Any]] = {}
    maker: dict[str, str] = {}
    by_step: dict[str, list[str]] = {}
    for key, node in nodes.items():
        by_step.setdefault(node["step"], []).append(key)
    for step in registry.steps().values():
        own = by_step.get(step.name, [])
        size = _size(step, [efforts[key] for key in own], cores, job_s) if step.swept else step.chunk[1]
        for batch in plan.evenly(own, size):
            needs = {maker[key] for node in batch for key in nodes[node]["inputs"].values()}
            name = plan.chunk_name([[labels[key]] for key in batch], batch)
            resources = footprint.resources(footprint.of_step(step), [efforts[key] for key in batch])
            chunks[name] = {"step": step.name, "nodes": batch, "needs": sorted(needs), "resources": resources}
            maker.update(dict.fromkeys(batch, name))
    targets: dict[str, list[str]] = {"all": [], "report": []}
    for number, run in enumerate(described):
        keys = {item["key"] for item in run["view"]}
        steps = sorted({nodes[key]["step"] for key in keys})
        name = plan.chunk_name([[f"{run['study']}.{run['name']}.all"]], [run["digest"]])
        needed = sorted({maker[key] for key in keys})
        chunks[name] = plan.publishing("all", steps, [number], needed)
        for target in ("all", "report"):
            targets[target].append(name)
        targets.setdefault(str(run["study"]), []).append(name)
    return chunks, targets


def _size(step: Step, efforts: Sequence[Effort | None], cores: int, job_s: float) -> int:
    """Return how many nodes of a swept step a job has, at most."""
    shared = min(_MOST, max(1, len(efforts) // (2 * cores)))
    work_s = sum(map(footprint.of_step(step).work_s, efforts)) / max(1, len(efforts))
    return max(shared, ceil(job_s / work_s))
