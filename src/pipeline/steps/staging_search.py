"""Staging search: a battery, its stages, weights and a search in; what its replicates found out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas_staging as schemas
from pipeline import tables
from pipeline.objective.staging_records import StagingProblem
from pipeline.objective.staging_runs import searched
from pipeline.search.registry import settings_from


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Run the search with all its replicates."""
    found = searched(
        StagingProblem.model_validate(settings["problem"]),
        settings_from(settings["search"]),
        int(settings["evaluations"]),
        int(settings["seed"]),
    )
    tables.write(schemas.STAGING_RUNS, found.runs, output / "runs.parquet")
    tables.write(schemas.STAGING_RUN_CURRENTS, found.currents, output / "run_currents.parquet")
    tables.write(schemas.STAGING_COURSE, found.course, output / "course.parquet")
