"""What the steps of the report need to name charges."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.report.data import ModeLabel, ReportData


def report_data(settings: Mapping[str, Any], inputs: Mapping[str, Path]) -> ReportData:
    """Return the artefacts of a run under the titles of its modes and comparisons, in the order of the run."""
    modes = {mode["name"]: ModeLabel(mode["title"], mode["knobs"]) for mode in settings["modes"]}
    comparisons = {comparison["name"]: comparison["title"] for comparison in settings["comparisons"]}
    return ReportData(inputs, modes, comparisons, settings.get("settings", {}), tuple(settings.get("cells", ())))
