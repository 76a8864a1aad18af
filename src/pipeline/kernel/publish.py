"""The readable view: `results/<study>/<run>/` and `reports/<study>/<run>/`, links into the store and a manifest."""

from __future__ import annotations

import json
import platform
import subprocess
from collections.abc import Collection, Iterator, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from pipeline.kernel import digest, store
from pipeline.kernel.planfile import command

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
        else:
            manifest = publish_run(run, results, chunk["part"], chunk["steps"])
        views[manifest.as_posix()] = run["digest"]
    store.write_receipt(results, "publish", name, {}, views)


def publish_run(run: Mapping[str, Any], results: Path, part: str, steps: Collection[str]) -> Path:
    """Link the artefacts that some steps made for a run, remove what an earlier publication left, write the manifest.

    Returns
    -------
    The manifest: `manifest.json` for all of a run, `manifest.<part>.json` for a part of it.
    """
    folder = view_folder(results, run, "results")
    _drop_other_runs(results, folder, run["digest"])
    manifest = folder / ("manifest.json" if part == "all" else f"manifest.{part}.json")
    shown = []
    for path, entry in _places(run, results, steps):
        store.link(store.artefact(results, entry["step"], entry["key"]) / entry["file"], path)
        shown.append(entry | {"path": path.relative_to(results.parent).as_posix()})
    store.write_json(manifest, _manifest(run, shown))
    return manifest


def publish_file(run: Mapping[str, Any], results: Path, path: str) -> Path:
    """Link one file of a run to its readable place, and list it in `manifest.files.json`, which is returned."""
    folder = view_folder(results, run, "results")
    _drop_other_runs(results, folder, run["digest"])
    manifest = folder / "manifest.files.json"
    shown = _read(manifest)["artefacts"] if manifest.is_file() else []
    target = results.parent / path
    items = [item for item in run["view"] if target.is_relative_to(view_folder(results, run, item["room"]))]
    items = [item for item in items if item["file"] == "*" or target.as_posix().endswith(f"/{item['place']}")]
    for item in items:
        if not (store.artefact(results, item["step"], item["key"]) / store.CONTENTS).is_file():
            continue
        for place, entry in _shown(run, results, item):
            if place == target:
                store.link(store.artefact(results, entry["step"], entry["key"]) / entry["file"], place)
                shown = [one for one in shown if one["path"] != path] + [entry | {"path": path}]
    store.write_json(manifest, _manifest(run, shown))
    return manifest


def drop_outdated(plan: Mapping[str, Any], results: Path, files: Mapping[str, str]) -> None:
    """Remove files asked for by their paths that are not what the plan's run would put there.

    Arguments
    ---------
    files : path -> the chunk that puts the file into its place.
    """
    for path, chunk in files.items():
        run = plan["runs"][plan["chunks"][chunk]["runs"][0]]
        target = results.parent / path
        if target.is_file() and digest.of_file(target) not in _listed(run, results, path):
            target.unlink()


def _listed(run: Mapping[str, Any], results: Path, path: str) -> set[str]:
    """Return the digests under which the manifests of a run list a path."""
    manifests = view_folder(results, run, "results").glob("manifest*.json")
    shown = [found for manifest in manifests if (found := _read(manifest))["digest"] == run["digest"]]
    return {entry["sha256"] for one in shown for entry in one["artefacts"] if entry["path"] == path}


def _drop_other_runs(results: Path, folder: Path, run_digest: str) -> None:
    """Remove what another configuration published to the same place, whole or in part, and its manifests."""
    for manifest in folder.glob("manifest*.json"):
        shown = _read(manifest)
        if shown["digest"] != run_digest:
            # The manifest first: without it nothing counts as published, whatever happens next.
            manifest.unlink()
            for entry in shown["artefacts"]:
                (results.parent / entry["path"]).unlink(missing_ok=True)


def _read(manifest: Path) -> dict[str, Any]:
    """Return a manifest; one that is damaged lists nothing and belongs to no run."""
    try:
        shown = json.loads(manifest.read_text())
        return {
            "digest": shown["digest"],
            "artefacts": [{**entry, "path": entry["path"]} for entry in shown["artefacts"]],
        }
    except (OSError, ValueError, KeyError, TypeError):
        return {"digest": None, "artefacts": []}


def view_folder(results: Path, run: Mapping[str, Any], room: str) -> Path:
    """Return the folder of a run's view in `results/` or in `reports/` beside it."""
    base = results if room == "results" else results.parent / room
    return base / str(run["study"]) / str(run["name"])


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
    return {
        "study": run["study"],
        "run": run["name"],
        "digest": run["digest"],
        "command": command(run["study"], run["overrides"]),
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
    run = subprocess.run(["git", *words], cwd=digest.PROJECT, capture_output=True, text=True, check=True)
    return run.stdout.strip()
