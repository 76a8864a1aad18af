"""Validation: a check of the engine and what it takes in; its rows and curves out."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import schemas_validation, tables
from pipeline.validation.records import Curve, Found, Row


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Run the check; a bound that is broken is written down, not raised."""
    found: Found = importlib.import_module(f"pipeline.validation.{settings['check']}").check(settings["settings"])
    tables.write(schemas_validation.VALIDATION_ROWS, _rows(found.rows), output / "rows.parquet")
    tables.write(schemas_validation.VALIDATION_CURVES, _curves(found.curves), output / "curves.parquet")


def _rows(rows: list[Row]) -> dict[str, list[Any]]:
    names = [column.name for column in schemas_validation.VALIDATION_ROWS.columns]
    return {name: [getattr(row, name) for row in rows] for name in names}


def _curves(curves: list[Curve]) -> dict[str, Any]:
    texts = ("group", "series", "across", "up")
    found: dict[str, Any] = {name: [getattr(one, name) for one in curves for _ in one.x] for name in texts}
    for name in ("x", "y"):
        found[name] = np.concatenate([getattr(one, name) for one in curves]) if curves else np.zeros(0)
    return found
