"""The papers' own tables, and what the names of inputs and the columns of tables say of what statements read."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.kernel.places import SHIPPED
from pipeline.kernel.tables import Table

REFERENCE = SHIPPED / "conf" / "published" / "reference"
"""The folder of the papers' own tables, a CSV file each."""
PRINTED = "reference"
"""First word of the names under which statements read them: `reference/<name>`."""


def reference_tables() -> list[Path]:
    """Return the files, which statements read as `reference/<name>`."""
    return sorted(REFERENCE.glob("*.csv"))


def is_named(table: Table) -> bool:
    """Tell whether a table holds a named number in each row; a statement reads them by that name."""
    return {"quantity", "value", "unit"} <= {column.name for column in table.columns}


@cache
def read_csv(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Return a printed table as column -> array: numbers where every cell is one or empty, else text."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: _numbers([row[name] for row in rows]) for name in (rows[0] if rows else ())}


def _numbers(cells: list[str]) -> np.ndarray[Any, Any]:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)
