"""What the terminal says of charges that ended before they were where they were to go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, store, tables


def unreached(plan: Mapping[str, Any], results: Path) -> Iterator[str]:
    """Yield a line for each charge of a plan that is in the store and reached none of its goals."""
    for run in plan["runs"]:
        for name, node in run["nodes"].items():
            summary = store.artefact(results, node["step"], node["key"]) / "summary.parquet"
            if node["step"] != "charge" or not summary.is_file():
                continue
            columns = tables.read(schemas.CHARGE_SUMMARY, summary)
            for quantity, text in zip(columns["quantity"], columns["text"], strict=True):
                if quantity == "missed":
                    yield f"{run['study']}/{run['name']} {name}: {text}"
