"""An artefact that was exchanged behind the store's back; last of these tests, since the failed job stays failed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipeline.kernel import store
from tests.workflow.conftest import Project

pytestmark = [pytest.mark.workflow]


def test_a_forced_job_that_finds_something_else_names_it(restored: Project) -> None:
    restored.snakemake("-R", "fit_panel", "--until", "fit_panel")
    manifest = json.loads((restored.folder / "results/solar_reflex/default/manifest.json").read_text())
    entry = next(entry for entry in manifest["artefacts"] if entry["path"].endswith("panel/points.parquet"))
    folder = restored.folder / "results/store/panel" / entry["key"]
    store.remove(folder)
    store.make(restored.folder / "results", "panel", entry["key"], _write_another)
    # With its receipt, the exchange would be noticed before anything runs, and the artefact made again.
    for receipt in (restored.folder / "results/receipts/panel").glob("*.json"):
        receipt.unlink()
    printed = restored.snakemake("-R", "fit_panel", "--until", "fit_panel", code=1)
    assert "points.parquet" in printed
    assert entry["key"] in printed
    store.remove(folder)


def _write_another(folder: Path) -> None:
    for name in ("curves", "parameters", "points"):
        (folder / f"{name}.parquet").write_text("something else")
