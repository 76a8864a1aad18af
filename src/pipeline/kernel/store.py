"""The keyed store under `results/`: what is written, whole or not at all, and what is still valid.

`results/store/<step>/<key>/` holds one artefact: its files, read-only, and `contents.json` with their sha256.
`results/receipts/<step>/<chunk>.json` says what a job made. This is the only module that writes under `results/`
and `reports/`.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pipeline.kernel import digest

CONTENTS = "contents.json"
RESULTS = Path("results")


class StoreError(RuntimeError):
    """An artefact that is missing, damaged, or came out different under the same key."""


def artefact(results: Path, step: str, key: str) -> Path:
    """Return the folder of an artefact."""
    return results / "store" / step / key


def receipt(results: Path, step: str, chunk: str) -> Path:
    """Return the file that says what a job made."""
    return results / "receipts" / step / f"{chunk}.json"


def contents(folder: Path) -> dict[str, str]:
    """Return file name -> sha256 of an artefact, as sealed; raise `StoreError` where it is not there."""
    try:
        listed: dict[str, str] = json.loads((folder / CONTENTS).read_text())
    except (OSError, ValueError) as error:
        raise StoreError(f"{folder}: no sealed artefact ({error})") from error
    if not isinstance(listed, dict):
        raise StoreError(f"{folder}: no sealed artefact ({CONTENTS} is no list of files)")
    return listed


def damage(folder: Path) -> str | None:
    """Return what is wrong with an artefact, or None where every file is what was sealed."""
    try:
        listed = contents(folder)
    except StoreError as error:
        return str(error)
    for name, expected in listed.items():
        path = folder / name
        if not path.is_file():
            return f"{path} is missing"
        if digest.of_file(path) != expected:
            return f"{path} is not what was sealed"
    return None


def make(results: Path, step: str, key: str, write: Callable[[Path], None], again: bool = False) -> dict[str, str]:
    """Make an artefact, unless it is there; return file name -> sha256.

    Arguments
    ---------
    write : fills the empty folder it is given; the folder gets its name only when everything is on disk.
    again : compute although the artefact is there, and compare.

    Raises
    ------
    StoreError : computed again, it came out different.
    """
    folder = artefact(results, step, key)
    fault = damage(folder)
    if fault is None and not again:
        return contents(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    _remove_abandoned(folder)
    temporary = Path(tempfile.mkdtemp(prefix=f".{key}.", suffix=f".{os.getpid()}", dir=folder.parent))
    try:
        write(temporary)
        made = _seal(temporary)
        if fault is None:
            _compare(folder, contents(folder), made)
        else:
            _replace(folder, temporary)
        return made
    finally:
        if temporary.exists():
            remove(temporary)


def found_value(folder: Path, name: str) -> Any:
    """Return a value that a step found, from `found.json` of its artefact: a number, a list, a record as plain data."""
    try:
        value = json.loads((folder / "found.json").read_text())[name]
    except (OSError, KeyError) as error:
        raise StoreError(f"{folder}: found no {name!r} ({error})") from error
    return value if isinstance(value, dict | list) else float(value)


def write_receipt(
    results: Path, step: str, chunk: str, artefacts: Mapping[str, Mapping[str, str]], views: Mapping[str, str]
) -> None:
    """Write what a job made: key -> (file -> sha256), and for published views manifest -> digest of the run."""
    made = {"step": step, "artefacts": artefacts, "views": views}
    write_json(receipt(results, step, chunk), made | {"stats": _stats(_sealed(results, made))})


def remove(folder: Path) -> None:
    """Delete an artefact, read-only files included."""
    for path in folder.rglob("*"):
        with contextlib.suppress(FileNotFoundError):
            path.chmod(0o755 if path.is_dir() else 0o644)
    shutil.rmtree(folder)


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    temporary = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(0o644)
        _rename(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    """Write a value as readable JSON, whole or not at all."""
    write_text(path, json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n")


def link(source: Path, target: Path) -> None:
    """Put a file under a second name: a hard link, or a copy where the file system has none; replaces `target`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.parent / f".{target.name}.{os.getpid()}"
    temporary.unlink(missing_ok=True)
    try:
        os.link(source, temporary)
    except OSError:
        shutil.copyfile(source, temporary)
        temporary.chmod(0o444)
    temporary.replace(target)
    # Renaming a link over another link to the same file leaves both names.
    temporary.unlink(missing_ok=True)


def drop_broken_receipts(
    results: Path,
    chunks: Mapping[str, Mapping[str, Any]],
    verify: bool = False,
    say: Callable[[str], None] = lambda line: None,
) -> list[str]:
    """Delete receipts whose artefacts are gone or whose view shows another run, and of all that was made from them.

    What changed since it was sealed goes to `results/quarantine/`. Size, time and inode are looked at; the content
    only where they differ from what the receipt keeps.

    Jobs that run again for want of a receipt compute only what is not in the store.

    Arguments
    ---------
    chunks : chunk -> its step and the chunks it needs, those before it.
    verify : read the content of every file.
    say : takes one line for each file that changed.

    Returns
    -------
    The names of the chunks whose receipts were deleted.
    """
    dropped: list[str] = []
    for name, chunk in chunks.items():
        path = receipt(results, chunk["step"], name)
        if path.is_file() and (not _honoured(results, path, verify, say) or set(chunk["needs"]) & set(dropped)):
            path.unlink(missing_ok=True)
            dropped.append(name)
    return dropped


def _honoured(results: Path, path: Path, verify: bool, say: Callable[[str], None]) -> bool:
    try:
        made = json.loads(path.read_text())
        sealed = all((artefact(results, made["step"], key) / CONTENTS).is_file() for key in made["artefacts"])
        shown = all(_shows(Path(view), run) for view, run in made["views"].items())
        return sealed and shown and _unchanged(results, path, made, verify, say)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError):
        return False


def _unchanged(results: Path, path: Path, made: Mapping[str, Any], verify: bool, say: Callable[[str], None]) -> bool:
    """Tell whether the files of a receipt are what was sealed; quarantine those that are not."""
    files = _sealed(results, made)
    now, kept = _stats(files), made.get("stats", {})
    suspects = [name for name in files if verify or now.get(name) != kept.get(name)]
    damaged = [name for name in suspects if name not in now or digest.of_file(Path(name)) != files[name]]
    for name in damaged:
        away = _quarantine(results, Path(name))
        say(f"{name} changed since it was sealed: {'moved to ' + str(away) if away else 'missing'}, made again")
    if not damaged and now != kept:
        # Same content under another time or inode: kept anew, and Snakemake need not see a younger receipt.
        times = path.stat()
        write_json(path, {**made, "stats": now})
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    return not damaged


def _sealed(results: Path, made: Mapping[str, Any]) -> dict[str, str]:
    """Return file -> sha256 of all that a receipt stands for, in the store and in the views."""
    files = {
        str(artefact(results, made["step"], key) / name): sha256
        for key, listed in made["artefacts"].items()
        for name, sha256 in listed.items()
    }
    for view in map(Path, made["views"]):
        for entry in json.loads(view.read_text())["artefacts"]:
            files[str(view.parents[3] / entry["path"])] = entry["sha256"]
    return files


def _stats(files: Mapping[str, str]) -> dict[str, list[int]]:
    """Return file -> size, time of change [ns], inode; without those that are missing."""
    found = {}
    for name in files:
        with contextlib.suppress(FileNotFoundError):
            stat = Path(name).stat()
            found[name] = [stat.st_size, stat.st_mtime_ns, stat.st_ino]
    return found


def _quarantine(results: Path, path: Path) -> Path | None:
    """Move a damaged file out of the way; return where it lies now, None where there was none."""
    if not path.is_file():
        return None
    folder = results / "quarantine"
    folder.mkdir(parents=True, exist_ok=True)
    away = Path(tempfile.mkdtemp(prefix=f"{path.parent.name[:12]}-", dir=folder)) / path.name
    path.replace(away)
    return away


def _shows(manifest: Path, run: str) -> bool:
    shown = json.loads(manifest.read_text())
    root = manifest.parents[3]
    return shown["digest"] == run and all((root / entry["path"]).is_file() for entry in shown["artefacts"])


def _seal(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    if not files:
        raise StoreError(f"{folder}: the step wrote nothing")
    listed = {path.relative_to(folder).as_posix(): digest.of_file(path) for path in files}
    (folder / CONTENTS).write_text(json.dumps(listed, indent=1, sort_keys=True) + "\n")
    for path in [*files, folder / CONTENTS]:
        path.chmod(0o444)
        _sync(path)
    folder.chmod(0o755)
    _sync(folder)
    return listed


def _replace(folder: Path, temporary: Path) -> None:
    if damage(folder) is None:
        return
    if folder.exists():
        remove(folder)
    try:
        _rename(temporary, folder)
    except OSError:
        # Another job may have sealed the same artefact meanwhile; then its copy serves.
        if damage(folder) is not None:
            raise


def _compare(folder: Path, before: Mapping[str, str], now: Mapping[str, str]) -> None:
    differing = sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))
    if differing:
        raise StoreError(f"computed again, {folder} came out different in: {', '.join(differing)}")


def _remove_abandoned(folder: Path) -> None:
    """Remove what a killed job left of the same artefact."""
    for path in folder.parent.glob(f".{folder.name}.*"):
        if not _alive(path.suffix):
            remove(path)


def _alive(suffix: str) -> bool:
    try:
        os.kill(int(suffix.lstrip(".")), 0)
    except (ValueError, ProcessLookupError):
        return False
    except PermissionError:
        return True
    return True


def _rename(source: Path, target: Path) -> None:
    source.replace(target)
    _sync(target.parent)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
