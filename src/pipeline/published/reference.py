"""The papers' own tables, which statements and pages read beside what is computed."""

from __future__ import annotations

from pathlib import Path

from pipeline.digest import PROJECT

REFERENCE = PROJECT / "conf" / "published" / "reference"
"""The folder they lie in, a CSV file each."""


def reference_tables() -> list[Path]:
    """Return the files, which statements read as `reference/<name>`."""
    return sorted(REFERENCE.glob("*.csv"))
