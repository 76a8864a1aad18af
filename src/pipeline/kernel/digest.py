"""Digests that decide whether work is still valid: of configuration, of files, of the lock file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.kernel.places import LOCK_FILE


def canonical(value: Any, ordered: bool = False) -> str:
    """Return JSON without spaces, one text for one value; NaN and infinity are refused.

    Arguments
    ---------
    ordered : keep the order of keys, for mappings in which it has a meaning (the phases of a mode); else sorted.
    """
    return json.dumps(value, sort_keys=not ordered, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def of_value(value: Any, ordered: bool = False) -> str:
    """Return the sha256 of a value's canonical JSON."""
    return hashlib.sha256(canonical(value, ordered).encode()).hexdigest()


def of_file(path: Path) -> str:
    """Return the sha256 of a file's content."""
    with path.open("rb") as file:
        found = hashlib.file_digest(file, "sha256").hexdigest()
    for record in _RECORDS:
        record[str(path.absolute())] = found
    return found


def is_there(path: Path) -> bool:
    """Tell whether a file is there, and keep in the records what was seen."""
    try:
        return bool(of_file(path))
    except OSError:
        for record in _RECORDS:
            record[str(path.absolute())] = ABSENT
        return False


def of_folder(folder: Path) -> str:
    """Return the sha256 of every file below a folder, by name and content; compiled Python is left out."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file() and path.suffix != ".pyc")
    return of_value([(path.relative_to(folder).as_posix(), of_file(path)) for path in files])


ABSENT = ""
"""What a record has of a file that was not there."""
_RECORDS: list[dict[str, str]] = []


@contextmanager
def recorded() -> Iterator[dict[str, str]]:
    """Give path -> sha256 of every file whose digest is taken meanwhile."""
    record: dict[str, str] = {}
    _RECORDS.append(record)
    try:
        yield record
    finally:
        _RECORDS.remove(record)


@cache
def of_lock() -> str:
    """Return the digest of the runtime lock file, comments and blank lines left out."""
    lines = (line.split("#")[0].strip() for line in LOCK_FILE.read_text().splitlines())
    return of_value([line for line in lines if line])
