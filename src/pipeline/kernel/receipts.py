"""Receipts: what each job made, and whether it is still there as it was sealed.

`results/receipts/<step>/<chunk>.json` is all that Snakemake looks at. A run reads the receipts of its plan first, and
deletes those that no longer tell the truth, so that the jobs behind them run again.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.kernel import digest, store

# Of a manifest, what may differ between two publications of the same run.
_CIRCUMSTANCES = ("commit", "lock", "versions")
# Receipts that are dated ahead by less are of a clock that is a little fast: nothing is said.
_AHEAD_S = 60.0

Say = Callable[[str], None]


# What a file that is no JSON of the expected form makes of whoever reads it.
_UNREADABLE = (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError)


class Broken(Exception):
    """A receipt that no longer stands for what is there; the message says why, empty where it is no damage."""


def path_of(results: Path, step: str, chunk: str) -> Path:
    """Return the file that says what a job made."""
    return results / "receipts" / step / f"{chunk}.json"


def write(
    results: Path,
    step: str,
    chunk: str,
    artefacts: Mapping[str, Mapping[str, str]],
    views: Mapping[str, Mapping[str, Any]],
) -> None:
    """Write what a job made.

    Arguments
    ---------
    artefacts : key -> (file -> sha256).
    views : manifest, from beside the results folder -> what `view` says of it.
    """
    made = {"step": step, "artefacts": artefacts, "views": views}
    store.write_json(path_of(results, step, chunk), made | {"stats": _stats(results, _files(results, made))})


def view(manifest: Mapping[str, Any], shown: Iterable[Mapping[str, Any]], whole: bool) -> dict[str, Any]:
    """Return what a receipt keeps of a published run: digests of the run and of its manifest, the files shown.

    Arguments
    ---------
    shown : entries of the manifest that the job is answerable for.
    whole : the manifest is of one job; to others, further jobs add their files.
    """
    left_out = {*_CIRCUMSTANCES} if whole else {*_CIRCUMSTANCES, "artefacts"}
    kept = {name: value for name, value in manifest.items() if name not in left_out}
    files = {str(entry["path"]): str(entry["sha256"]) for entry in shown}
    return {"run": manifest["digest"], "whole": whole, "manifest": digest.of_value(kept), "shown": files}


def drop_broken(
    results: Path,
    chunks: Mapping[str, Mapping[str, Any]],
    verify: bool = False,
    say: Say = lambda line: None,
    look: bool = False,
) -> list[str]:
    """Delete receipts whose artefacts are gone or whose view shows another run, and of all that was made from them.

    What changed since it was sealed goes to `results/quarantine/`. Size, time and inode are looked at; the content
    only where they differ from what the receipt keeps. Receipts are dated in the order of the plan and none ahead of
    the clock, so that Snakemake has nothing to find fault with.

    Jobs that run again for want of a receipt compute only what is not in the store.

    Arguments
    ---------
    chunks : chunk -> its step, the keys of its nodes if it has any, and the chunks it needs, those before it.
    verify : read the content of every file.
    say : takes one line for each file that changed.
    look : tell only; nothing is deleted, moved or dated anew.

    Returns
    -------
    The names of the chunks whose receipts were deleted, or would be.
    """
    check = _Check(results, verify, say, look)
    dropped: dict[str, None] = {}
    dated: dict[str, int] = {}
    for name, chunk in chunks.items():
        path = path_of(results, chunk["step"], name)
        if not path.exists() and not path.is_symlink():
            continue
        honoured = check.honours(path, chunk["step"], chunk.get("nodes", ()))
        if honoured and dropped.keys().isdisjoint(chunk["needs"]):
            dated[name] = check.date(path, [dated[need] for need in chunk["needs"] if need in dated])
            continue
        if not look:
            path.unlink(missing_ok=True)
        dropped[name] = None
    return list(dropped)


def faults(results: Path) -> Iterator[str]:
    """Yield what is wrong with the receipts in a folder, or missing of what they stand for.

    Views that show another run by now are no fault; the content of files is not read.
    """
    said: list[str] = []
    check = _Check(results, False, said.append, look=True)
    for path in sorted((results / "receipts").glob("*/*.json")):
        if path.name.startswith("."):
            continue
        said.clear()
        if not check.honours(path, path.parent.name, files=False):
            yield from (f"{path}: {line}" for line in said)


def forget(results: Path, artefacts: Collection[str]) -> int:
    """Delete the receipts of artefacts that were removed on purpose; return how many.

    Arguments
    ---------
    artefacts : step/key of each.
    """
    gone = 0
    for path in (results / "receipts").glob("*/*.json"):
        try:
            keys = json.loads(path.read_text(encoding="utf-8"))["artefacts"]
            stale = any(f"{path.parent.name}/{key}" in artefacts for key in keys)
        except _UNREADABLE:
            continue
        if stale:
            path.unlink(missing_ok=True)
            gone += 1
    return gone


class _Check:
    """One look at the receipts of a folder."""

    def __init__(self, results: Path, verify: bool, say: Say, look: bool) -> None:
        self._results = results
        self._verify = verify
        self._say = say
        self._look = look
        self._now = time.time_ns()

    def honours(self, path: Path, step: str, keys: Collection[str] = (), files: bool = True) -> bool:
        """Tell whether all that a receipt stands for is there, as it was sealed; say what is not, move it away.

        Arguments
        ---------
        keys : of the artefacts that the plan expects of the job; looked at where the receipt cannot be read.
        files : look at each file too, not only at the lists of them.
        """
        try:
            made = self._read(path, step)
        except Broken as broken:
            self._say(str(broken))
            for key in keys:
                self._look_at(store.artefact(self._results, step, key))
            return False
        faults = {key: self._fault(self._sealed, step, key, listed) for key, listed in made["artefacts"].items()}
        root = self._results.parent
        faults |= {name: self._fault(self._shows, root / name, kept) for name, kept in made["views"].items()}
        whole = all(fault is None for fault in faults.values())
        # Files of an artefact that is broken as a whole, or of a view that shows another run, are not looked at.
        rest = {
            "step": step,
            "artefacts": {key: listed for key, listed in made["artefacts"].items() if faults[key] is None},
            "views": {name: kept for name, kept in made["views"].items() if faults[name] != ""},
        }
        return (not files or self._unchanged(path, made, _files(self._results, rest), whole)) and whole

    def _fault(self, check: Callable[..., None], *arguments: Any) -> str | None:
        """Return what a check finds wrong, which is said; None where it finds nothing."""
        try:
            check(*arguments)
        except Broken as broken:
            if str(broken):
                self._say(str(broken))
            return str(broken)
        return None

    def date(self, path: Path, needs: list[int]) -> int:
        """Return the time of a receipt, not before those it needs and not ahead of the clock, and date it so [ns]."""
        own = path.stat().st_mtime_ns
        wanted = min(self._now, max([own, *needs]))
        if wanted != own and not self._look:
            if own - self._now > _AHEAD_S * 1e9:
                ahead = time.strftime("%Y-%m-%d %H:%M", time.gmtime(own // 10**9))
                self._say(f"{path} is dated {ahead} UTC, ahead of the clock: dated anew")
            os.utime(path, ns=(wanted, wanted))
        return wanted

    def _read(self, path: Path, step: str) -> dict[str, Any]:
        if not path.is_file() or path.is_symlink():
            away = self._quarantine(path)
            raise Broken(f"{path} is no file: {_where(away)}, written anew")
        try:
            made: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            files, own = _files(self._results, made), made["step"]
            kept = [(str(one["run"]), one["whole"], str(one["manifest"])) for one in made["views"].values()]
            stats = {str(name): [int(number) for number in one] for name, one in made["stats"].items()}
        except _UNREADABLE:
            raise Broken(f"{path} cannot be read: written anew") from None
        inside = (store.inside(self._results, place) for place in (*files, *made["views"]))
        if own != step or len(kept) != len(made["views"]) or not all(inside):
            raise Broken(f"{path} is not the receipt of this job: written anew")
        return made | {"stats": stats}

    def _look_at(self, folder: Path) -> None:
        """Say what is wrong with an artefact that no receipt vouches for, and move it away."""
        if not folder.is_dir():
            self._say(f"{folder} is missing: made again")
        elif (fault := store.damage(folder)) is not None:
            away = self._quarantine(folder)
            self._say(f"{fault}: made again" if away is None else f"{fault}: made again, {folder.name} {_where(away)}")

    def _sealed(self, step: str, key: str, listed: Mapping[str, str]) -> None:
        folder = store.artefact(self._results, step, key)
        if not folder.is_dir() or not (folder / store.CONTENTS).exists():
            raise Broken(f"{folder} is missing: made again")
        try:
            found = store.contents(folder)
        except store.StoreError:
            found = {}
        if found != dict(listed):
            away = self._quarantine(folder / store.CONTENTS)
            raise Broken(f"{folder / store.CONTENTS} changed since it was sealed: {_where(away)}, made again")

    def _shows(self, manifest: Path, kept: Mapping[str, Any]) -> None:
        if not manifest.exists() and not manifest.is_symlink():
            # Another run publishes into the same place only after this one's manifest is gone.
            raise Broken("")
        try:
            found = json.loads(manifest.read_text(encoding="utf-8"))
            lists = {entry["path"]: entry for entry in found["artefacts"]}
            run = found["digest"]
            now = view(found, [lists[path] for path in kept["shown"] if path in lists], kept["whole"])
        except _UNREADABLE:
            away = self._quarantine(manifest)
            raise Broken(f"{manifest} cannot be read: {_where(away)}, written anew") from None
        if run != kept["run"]:
            raise Broken("")
        if now != kept:
            away = self._quarantine(manifest)
            raise Broken(f"{manifest} changed since it was written: {_where(away)}, written anew")

    def _unchanged(self, path: Path, made: Mapping[str, Any], files: Mapping[str, str], whole: bool) -> bool:
        """Tell whether some files of a receipt are what was sealed; quarantine those that are not."""
        now, kept = _stats(self._results, files), made["stats"]
        root = self._results.parent
        suspects = [name for name in files if self._verify or now.get(name) != kept.get(name)]
        damaged = [root / name for name in suspects if not _is(root / name, files[name])]
        for file in damaged:
            away = self._quarantine(file)
            told = (
                "is missing: made again" if away is None else f"changed since it was sealed: {_where(away)}, made again"
            )
            self._say(f"{file} {told}")
        if whole and not damaged and now != kept and not self._look:
            # Same content under another time or inode: kept anew, and Snakemake need not see a younger receipt.
            times = path.stat()
            store.write_json(path, {**made, "stats": now})
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        return not damaged

    def _quarantine(self, path: Path) -> Path | None:
        if self._look:
            return path if path.exists() or path.is_symlink() else None
        return store.quarantine(self._results, path)


def _where(away: Path | None) -> str:
    return "missing" if away is None else f"moved to {away}"


def _files(results: Path, made: Mapping[str, Any]) -> dict[str, str]:
    """Return file -> sha256 of all that a receipt stands for, in the store and in the views, from beside `results`."""
    files = {
        f"{results.name}/store/{made['step']}/{key}/{name}": str(sha256)
        for key, listed in made["artefacts"].items()
        for name, sha256 in listed.items()
    }
    for one in made["views"].values():
        files |= {str(name): str(sha256) for name, sha256 in one["shown"].items()}
    return files


def _stats(results: Path, files: Iterable[str]) -> dict[str, list[int]]:
    """Return file -> size, time of change [ns], inode; without those that are missing."""
    found = {}
    for name in files:
        with contextlib.suppress(OSError):
            stat = (results.parent / name).stat()
            found[name] = [stat.st_size, stat.st_mtime_ns, stat.st_ino]
    return found


def _is(path: Path, sha256: str) -> bool:
    return path.is_file() and digest.of_file(path) == sha256
