"""What is taken of a person's own files when planning: by its digest a plan knows that one has changed since."""

from __future__ import annotations

from pathlib import Path

from pipeline.kernel.digest import of_file


def digest(path: Path) -> str:
    """Return the sha256 of a file's content as it lies there; empty where it cannot be read.

    A plan that is remembered is made again when it is another one: whatever planning reads has to pass here.
    """
    try:
        return of_file(path) if path.is_file() else ""
    except (OSError, ValueError):
        return ""
