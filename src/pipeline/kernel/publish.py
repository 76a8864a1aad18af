"""The readable view: `results/<study>/<run>/` and `reports/<study>/<run>/`, links into the store and a manifest."""

from __future__ import annotations

import json
import platform
import subprocess
from collections.abc import Collection, Iterator, Mapping
from importlib import import_module, metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.kernel import digest, places, receipts, store
from pipeline.kernel.planfile import command

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pipeline.kernel.tables import TableFile

MANIFEST = "manifest.json"
"""The manifest of a run that was published whole."""
FILES = "manifest.files.json"
"""The manifest of files that were asked for by their paths; many jobs add to it."""

VERSIONS_OF = (
    "charge-pipeline",
    "hydra-core",
    "matplotlib",
    "numba",
    "numpy",
    "pandas",
    "pvlib",
    "pyarrow",
    "pydantic",
    "scipy",
    "snakemake",
)


def publish(plan: Mapping[str, Any], name: str, results: Path) -> None:
    """Link the artefacts of a chunk's runs to their readable places, write the manifests, then the receipt."""
    chunk = plan["chunks"][name]
    views = {}
    for index in chunk["runs"]:
        run = plan["runs"][index]
        if "/" in chunk["part"]:
            manifest = publish_file(run, results, chunk["part"])
            shown = [entry for entry in _read(results, manifest)["artefacts"] if entry["path"] == chunk["part"]]
        else:
            manifest = publish_run(run, results, chunk["part"], chunk["steps"])
            shown = _read(results, manifest)["artefacts"]
        for module in plan.get("announces", ()):
            import_module(module).published(run, _read(results, manifest), results)
        place = manifest.relative_to(results.parent).as_posix()
        views[place] = receipts.view(_read(results, manifest), shown, whole=manifest.name != FILES)
    receipts.write(results, "publish", name, {}, views)


def own(plan: Mapping[str, Any], results: Path) -> None:
    """Make sure that what a plan writes is reached through folders of its own.

    Raises
    ------
    UserError : a symbolic link, or a file, is in the way.
    """
    for name in ("plan", "store", "receipts", "logs", "benchmarks", "quarantine"):
        store.own(results, results / name / "file")
        for step in plan["steps"] if name != "plan" else ():
            store.own(results, results / name / step / "file")
    for run in plan["runs"]:
        for room in ("results", "reports"):
            root = results if room == "results" else results.parent / room
            folders = {Path(item["place"]).parent for item in run["view"] if item["room"] == room}
            for folder in sorted(folders | {Path()}):
                store.own(root, view_folder(results, run, room) / folder / "file")


def publish_run(run: Mapping[str, Any], results: Path, part: str, steps: Collection[str]) -> Path:
    """Link the artefacts that some steps made for a run, remove what an earlier publication left, write the manifest.

    Returns
    -------
    The manifest: `manifest.json` for all of a run, `manifest.<part>.json` for a part of it.
    """
    folder = view_folder(results, run, "results")
    _drop_other_runs(results, folder, run["digest"])
    manifest = folder / (MANIFEST if part == "all" else f"manifest.{part}.json")
    shown = []
    for step, key in dict.fromkeys((item["step"], item["key"]) for item in run["view"] if item["step"] in steps):
        store.whole(results, step, key, f"{run['study']}/{run['name']}")
    for path, entry in _places(run, results, steps):
        _link(results, entry, path)
        shown.append(entry | {"path": path.relative_to(results.parent).as_posix()})
    store.write_json(manifest, _manifest(run, shown))
    return manifest


def publish_file(run: Mapping[str, Any], results: Path, path: str) -> Path:
    """Link one file of a run to its readable place, and list it in `manifest.files.json`, which is returned."""
    folder = view_folder(results, run, "results")
    _drop_other_runs(results, folder, run["digest"])
    manifest = folder / FILES
    shown = _read(results, manifest)["artefacts"]
    target = results.parent / path
    items = [item for item in run["view"] if target.is_relative_to(view_folder(results, run, item["room"]))]
    items = [item for item in items if item["file"] == "*" or target.as_posix().endswith(f"/{item['place']}")]
    for item in items:
        if not store.artefact(results, item["step"], item["key"]).is_dir():
            continue
        store.whole(results, item["step"], item["key"], path)
        for place, entry in _shown(run, results, item):
            if place == target:
                _link(results, entry, place)
                shown = [one for one in shown if one["path"] != path] + [entry | {"path": path}]
    store.write_json(manifest, _manifest(run, shown))
    return manifest


def drop_outdated(plan: Mapping[str, Any], results: Path, files: Mapping[str, str], look: bool = False) -> list[str]:
    """Remove files asked for by their paths that are not what the plan's run would put there; return their chunks.

    Arguments
    ---------
    files : path -> the chunk that puts the file into its place.
    look : tell only, remove nothing.
    """
    outdated = []
    for path, chunk in files.items():
        run = plan["runs"][plan["chunks"][chunk]["runs"][0]]
        target = results.parent / path
        if target.is_file() and digest.of_file(target) not in _listed(run, results, path):
            outdated.append(chunk)
            if not look:
                target.unlink()
    return outdated


def _listed(run: Mapping[str, Any], results: Path, path: str) -> set[str]:
    """Return the digests under which the manifests of a run list a path."""
    manifests = view_folder(results, run, "results").glob("manifest*.json")
    shown = [found for manifest in manifests if (found := _read(results, manifest))["digest"] == run["digest"]]
    return {entry["sha256"] for one in shown for entry in one["artefacts"] if entry["path"] == path}


def _drop_other_runs(results: Path, folder: Path, run_digest: str) -> None:
    """Remove what another configuration published to the same place, whole or in part, and its manifests."""
    for manifest in folder.glob("manifest*.json"):
        shown = _read(results, manifest)
        if shown["digest"] != run_digest:
            # The manifest first: without it nothing counts as published, whatever happens next.
            store.remove(manifest)
            for path in (results.parent / entry["path"] for entry in shown["artefacts"]):
                if not path.is_dir():
                    path.unlink(missing_ok=True)


def _link(results: Path, entry: Mapping[str, Any], path: Path) -> None:
    """Put a file of an artefact into its readable place; a folder that stands there is moved away."""
    store.own(results.parent / path.relative_to(results.parent).parts[0], path)
    if path.is_dir() and not path.is_symlink():
        store.quarantine(results, path)
    store.link(store.artefact(results, entry["step"], entry["key"]) / entry["file"], path)


def _read(results: Path, manifest: Path) -> dict[str, Any]:
    """Return a manifest; one that is damaged, or lists what is not of these folders, belongs to no run."""
    try:
        shown: dict[str, Any] = json.loads(manifest.read_text(encoding="utf-8"))
        mine = manifest.parent.relative_to(results).parts
        paths = [Path(entry["path"]) for entry in shown["artefacts"]]
        own = (path.parts[1 : 1 + len(mine)] == mine and store.inside(results, path.as_posix()) for path in paths)
        if shown["digest"] and all(own):
            return shown
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass
    return {"digest": None, "artefacts": []}


def manifests(results: Path) -> list[Path]:
    """Return the manifests of all runs, and sweeps, that a folder shows."""
    return sorted(path for pattern in ("*/*", "*/sweeps/*") for path in results.glob(f"{pattern}/manifest*.json"))


def view_folder(results: Path, run: Mapping[str, Any], room: str) -> Path:
    """Return the folder of a run's view in `results/` or in `reports/` beside it."""
    base = results if room == "results" else results.parent / room
    return base / str(run["study"]) / str(run["name"])


def made(
    run: Mapping[str, Any], step: str, file: TableFile, results: Path
) -> Iterator[tuple[str, Mapping[str, NDArray[Any]]]]:
    """Yield name and table of every node of a step that a run has and the store holds.

    Arguments
    ---------
    run : as the plan holds it.
    file : which of the step's tables.
    """
    # Whoever only plans does without Arrow.
    from pipeline.kernel import tables

    for name, node in run["nodes"].items():
        path = store.artefact(results, node["step"], node["key"]) / file.file
        if node["step"] == step and path.is_file():
            yield name, tables.read(file.table, path)


def _places(run: Mapping[str, Any], results: Path, steps: Collection[str]) -> Iterator[tuple[Path, dict[str, Any]]]:
    for item in run["view"]:
        if item["step"] in steps:
            yield from _shown(run, results, item)


def _shown(run: Mapping[str, Any], results: Path, item: Mapping[str, Any]) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield the readable place of every file that an entry of a run's view stands for, and what the manifest says."""
    sealed = store.contents(store.artefact(results, item["step"], item["key"]))
    for file in sorted(sealed) if item["file"] == "*" else [item["file"]]:
        place = f"{item['place']}{file}" if item["file"] == "*" else item["place"]
        entry = {"step": item["step"], "key": item["key"], "file": file, "sha256": sealed[file]}
        yield view_folder(results, run, item["room"]) / place, entry


def _manifest(run: Mapping[str, Any], shown: list[dict[str, Any]]) -> dict[str, Any]:
    return ({"sweep": run["sweep"]} if "sweep" in run else {}) | {
        "study": run["study"],
        "run": run["name"],
        "digest": run["digest"],
        "command": run.get("command") or command(run["study"], run["overrides"]),
        "overrides": run["overrides"],
        "seed": run["seed"],
        "configuration": run["configuration"],
        "sources": run["sources"],
        "artefacts": shown,
        "nodes": run["nodes"],
        "lock": digest.of_lock(),
        "commit": _commit(),
        "versions": {"python": platform.python_version()} | {name: metadata.version(name) for name in VERSIONS_OF},
    }


def _commit() -> str | None:
    """Return the commit of the project's tree, `+changes` where files differ from it; None outside a repository."""
    try:
        head = _git("rev-parse", "HEAD")
        return head + ("+changes" if _git("status", "--porcelain") else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(*words: str) -> str:
    run = subprocess.run(["git", *words], cwd=places.PROJECT, capture_output=True, text=True, check=True)
    return run.stdout.strip()
