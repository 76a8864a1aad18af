"""Verdicts: published statements and the artefacts that answer them in; a computed verdict on each out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, tables
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import evaluate
from pipeline.published.records import Statement
from pipeline.published.reference import reference_tables
from pipeline.published.second_cell import answered_by_charges, in_place_of_the_first


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Judge every statement, and those that charges answer on the second battery's charges too."""
    statements = {
        data["name"]: Statement.model_validate({key: value for key, value in data.items() if key != "name"})
        for data in settings["statements"]
    }
    tables_of_papers = {f"reference/{path.stem}": path for path in reference_tables()}
    verdicts = evaluate(statements, Lookup({**inputs, **tables_of_papers}), set(settings["calibrated"]))
    tables.write(schemas.VERDICTS, verdicts, output / "verdicts.parquet")
    if "second_calibrated" in settings:
        second = Lookup(in_place_of_the_first(inputs))
        verdicts = evaluate(answered_by_charges(statements), second, set(settings["second_calibrated"]))
        tables.write(schemas.VERDICTS, verdicts, output / "second.parquet")
