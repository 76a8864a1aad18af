"""The keyed store under `results/`: what is written, whole or not at all, and what is still valid.

`results/store/<step>/<key>/` holds one artefact: its files, read-only, and `contents.json` with their sha256. This is
the only module that writes artefacts, texts and links under `results/` and `reports/`. What is being written has a
name with a dot in front, the machine and the number of its process behind: `.<name>.<letters>.<machine>-<process>`.

Nothing here needs hard links, locks or a rename of folders, which file systems of a network may refuse: what makes an
artefact whole is `contents.json`, which comes last.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import re
import shutil
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.kernel import digest
from pipeline.kernel.errors import UserError

CONTENTS = "contents.json"
RESULTS = Path("results")
REPORTS = "reports"
_TEMPORARY = re.compile(r"\..+\.(?:(?:(?P<machine>[0-9a-f]{8})-)?(?P<process>\d+)|[a-z0-9_]{8})")
_MACHINE = hashlib.sha256(socket.gethostname().encode()).hexdigest()[:8]
_LONGEST_JOB_S = 8 * 86_400.0
"""After which what a process of another machine has not gone on writing is taken for left behind."""
_NO_RENAME = (errno.EPERM, errno.EXDEV, errno.ENOTEMPTY, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL)
_NO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.EBADF, errno.EACCES, errno.EISDIR)
patience_s = 0.0
"""How long an input that is not seen is waited for: a network's file system is late with what another machine made."""


class StoreError(RuntimeError):
    """An artefact that is missing, damaged, or came out different under the same key."""


def artefact(results: Path, step: str, key: str) -> Path:
    """Return the folder of an artefact."""
    return results / "store" / step / key


def contents(folder: Path) -> dict[str, str]:
    """Return file name -> sha256 of an artefact, as sealed; raise `StoreError` where it is not there."""
    try:
        listed: dict[str, str] = json.loads((folder / CONTENTS).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise StoreError(f"{folder}: no sealed artefact ({error})") from error
    if not isinstance(listed, dict) or not all(isinstance(sha256, str) for sha256 in listed.values()):
        raise StoreError(f"{folder}: no sealed artefact ({CONTENTS} is no list of files)")
    return listed


def whole(results: Path, step: str, key: str, use: str) -> Path:
    """Return the folder of an artefact that is what was sealed, for whoever builds on it.

    Raises
    ------
    StoreError : it is not; the folder goes to the quarantine, so that the next run makes it again.
    """
    folder = artefact(results, step, key)
    end = time.monotonic() + patience_s
    while (fault := damage(folder)) is not None and not folder.exists() and time.monotonic() < end:
        time.sleep(min(1.0, patience_s))
        # To list a folder is what makes such a file system look again.
        with contextlib.suppress(OSError):
            list(folder.parent.iterdir())
    if fault is None:
        return folder
    away = quarantine(results, folder)
    moved = f" (moved to {away})" if away else ""
    raise StoreError(f"{use}: {fault}{moved}; run the same command again, which makes it anew")


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
            return f"{path} changed since it was sealed"
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
    return make_many(results, step, [key], lambda folders: write(folders[key]), again)[key]


def make_many(
    results: Path,
    step: str,
    keys: Sequence[str],
    write: Callable[[Mapping[str, Path]], None],
    again: bool = False,
) -> dict[str, dict[str, str]]:
    """Make those of some artefacts of a step that are not there, on disk at once; return key -> (file -> sha256).

    Arguments
    ---------
    write : fills the empty folders it is given, by key; they get their names only when everything is on disk.
    again : compute although they are there, and compare.

    Raises
    ------
    StoreError : computed again, one came out different.
    """
    folders = {key: artefact(results, step, key) for key in keys}
    faults = {key: damage(folder) for key, folder in folders.items()}
    made = {key: contents(folders[key]) for key in keys if faults[key] is None and not again}
    wanted = [key for key in keys if key not in made]
    if not wanted:
        return made
    parent = folders[keys[0]].parent
    parent.mkdir(parents=True, exist_ok=True)
    _remove_abandoned(parent)
    end = _owner()
    temporary = {key: Path(tempfile.mkdtemp(prefix=f".{key}.", suffix=end, dir=parent)) for key in wanted}
    try:
        write(temporary)
        sealed = {key: _seal(folder) for key, folder in temporary.items()}
        _on_disk(temporary.values())
        for key, listed in sealed.items():
            if faults[key] is None:
                _compare(folders[key], contents(folders[key]), listed)
            else:
                _replace(results, folders[key], temporary[key])
        _sync(parent)
        return made | sealed
    finally:
        for folder in temporary.values():
            if folder.exists():
                remove(folder)


def found_value(folder: Path, name: str) -> Any:
    """Return a value that a step found, from `found.json` of its artefact: a number, a list, a record as plain data."""
    try:
        value = json.loads((folder / "found.json").read_text(encoding="utf-8"))[name]
    except (OSError, ValueError, KeyError) as error:
        raise StoreError(f"{folder}: found no {name!r} ({error})") from error
    return value if isinstance(value, dict | list) else float(value)


def remove(folder: Path) -> None:
    """Delete an artefact, read-only files included, or a file that lies in its place."""
    if folder.is_symlink() or not folder.is_dir():
        folder.unlink(missing_ok=True)
        return
    for path in folder.rglob("*"):
        if path.is_symlink():
            continue
        with contextlib.suppress(FileNotFoundError):
            path.chmod(0o755 if path.is_dir() else 0o644)
    shutil.rmtree(folder)


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=_owner(), dir=path.parent)
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
    temporary = target.parent / f".{target.name}{_owner()}"
    temporary.unlink(missing_ok=True)
    try:
        os.link(source, temporary)
    except OSError:
        shutil.copyfile(source, temporary)
        temporary.chmod(0o444)
    temporary.replace(target)
    # Renaming a link over another link to the same file leaves both names.
    temporary.unlink(missing_ok=True)


def quarantine(results: Path, path: Path) -> Path | None:
    """Move what is damaged out of the way; return where it lies now, None where there was nothing."""
    if not (path.exists() or path.is_symlink()):
        return None
    # One folder deeper than a view: a manifest there is found by nobody who looks for runs.
    folder = results / "quarantine" / path.parent.name[:12]
    folder.mkdir(parents=True, exist_ok=True)
    away = Path(tempfile.mkdtemp(prefix="changed-", dir=folder)) / path.name
    try:
        _move(path, away)
    except FileNotFoundError:
        return None
    return away


def inside(results: Path, place: str) -> bool:
    """Tell whether a path, from beside the results folder, stays in it or in the reports."""
    parts = Path(place).parts
    return len(parts) > 1 and parts[0] in (results.name, REPORTS) and ".." not in parts


def own(root: Path, path: Path) -> None:
    """Make sure that a file or folder below a root is reached through folders of its own.

    Raises
    ------
    UserError : a symbolic link, or a file, stands on the way; nothing is written through it.
    """
    for part in reversed(path.relative_to(root).parents[:-1]):
        folder = root / part
        if folder.is_symlink():
            raise UserError(
                f"{folder}: a symbolic link (to {folder.readlink()}); what is written stays in {root}: remove the "
                "link and run again, or make the whole of it a link"
            )
        if folder.exists() and not folder.is_dir():
            raise UserError(f"{folder}: a file where a folder belongs; move it away and run again")


def abandoned(results: Path) -> Iterator[Path]:
    """Yield the temporary files and folders under `results/` and `reports/` that no living process owns."""
    for root in (results, results.parent / REPORTS):
        for base, folders, files in os.walk(root):
            temporary = [name for name in (*folders, *files) if _is_abandoned(Path(base) / name)]
            folders[:] = [name for name in folders if name not in temporary]
            yield from (Path(base) / name for name in temporary)


def _seal(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    if not files:
        raise StoreError(f"{folder}: the step wrote nothing")
    listed = {path.relative_to(folder).as_posix(): digest.of_file(path) for path in files}
    (folder / CONTENTS).write_text(json.dumps(listed, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    for path in [*files, folder / CONTENTS]:
        path.chmod(0o444)
    folder.chmod(0o755)
    return listed


def _on_disk(folders: Collection[Path]) -> None:
    """Wait until all files of some folders are on disk."""
    # One call for many files: a commit of the journal for each takes 3 ms, whatever its size.
    if len(folders) > 1 and sys.platform == "linux":
        os.sync()
        return
    for folder in folders:
        for path in [*folder.rglob("*"), folder]:
            _sync(path)


def _replace(results: Path, folder: Path, temporary: Path) -> None:
    if damage(folder) is None:
        return
    quarantine(results, folder)
    try:
        _move(temporary, folder)
    except OSError:
        # Another job may have sealed the same artefact meanwhile; then its copy serves.
        if damage(folder) is not None:
            raise


def _move(source: Path, target: Path) -> None:
    """Give a file or folder another name where nothing is yet; copy it where the file system renames no folders."""
    try:
        source.replace(target)
        return
    except OSError as error:
        if error.errno not in _NO_RENAME or not source.is_dir() or source.is_symlink() or target.exists():
            raise
    target.mkdir()
    target.chmod(0o755)
    # What makes it whole comes last.
    for path in sorted(source.rglob("*"), key=lambda path: path == source / CONTENTS):
        copy = target / path.relative_to(source)
        if path.is_dir():
            copy.mkdir(parents=True, exist_ok=True)
        else:
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
            shutil.copymode(path, copy)
            _sync(copy)
    _sync(target)
    remove(source)


def _compare(folder: Path, before: Mapping[str, str], now: Mapping[str, str]) -> None:
    differing = sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))
    if differing:
        raise StoreError(f"computed again, {folder} came out different in: {', '.join(differing)}")


def _remove_abandoned(folder: Path) -> None:
    """Remove what killed jobs left in the folder of a step."""
    for path in folder.glob(".*"):
        if _is_abandoned(path):
            remove(path)


def _owner() -> str:
    """Return what stands behind the names of all that this process is writing."""
    return f".{_MACHINE}-{os.getpid()}"


def _is_abandoned(path: Path) -> bool:
    """Tell whether something was being written by a process that is no more."""
    found = _TEMPORARY.fullmatch(path.name)
    if found is None:
        return False
    if found["machine"] in (None, _MACHINE):
        # Without a process: of the days when temporary names had none.
        return not (found["process"] and _alive(int(found["process"])))
    try:
        # Whether a process of another machine lives cannot be asked here.
        return time.time() - path.lstat().st_mtime > _LONGEST_JOB_S
    except OSError:
        return False


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _rename(source: Path, target: Path) -> None:
    source.replace(target)
    _sync(target.parent)


def _sync(path: Path) -> None:
    folder = path.is_dir()
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        # Some file systems of a network have nothing to wait for in a folder.
        if not folder or error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)
