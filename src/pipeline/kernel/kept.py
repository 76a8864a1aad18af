"""What one process found out and a later one need not: files of the cache, each whole or as if it were not there."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from pipeline.kernel.places import cache_root


def read(name: str) -> Any:
    """Return a value as it was written; None where there is none, or the file is not as it was written.

    Arguments
    ---------
    name : of a file of the cache, e.g. `code.json`.
    """
    try:
        said, _, text = (cache_root() / name).read_text(encoding="utf-8").partition("\n")
        return json.loads(text) if hashlib.sha256(text.encode()).hexdigest() == said else None
    except (OSError, ValueError, RecursionError):
        return None


def write(name: str, value: Any, most: int | None = None) -> None:
    """Write a value; where the cache cannot be written to, nothing is kept. Another process's write may win.

    Arguments
    ---------
    most : files that its folder holds at the end, the oldest go.
    """
    text = json.dumps(value, ensure_ascii=False)
    file = cache_root() / name
    temporary = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}", encoding="utf-8")
        temporary.replace(file)
        if most is not None:
            _drop(file.parent, most)
    except OSError:
        with suppress(OSError):
            temporary.unlink()


def _drop(folder: Path, most: int) -> None:
    by_age = sorted(folder.iterdir(), key=lambda path: path.lstat().st_mtime_ns)
    for path in by_age[: max(0, len(by_age) - most)]:
        path.unlink(missing_ok=True)
