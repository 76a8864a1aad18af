"""Charge traces are valid files of the Battery Data Format."""

from __future__ import annotations

import warnings

import pandas as pd
import pytest

from tests.workflow.conftest import Project

pytestmark = [pytest.mark.workflow]


def test_every_trace_passes_the_formats_own_validator(project: Project) -> None:
    with warnings.catch_warnings():
        # The validator's own imports warn of things in other packages.
        warnings.simplefilter("ignore")
        from bdf.validate import validate_df

    traces = sorted((project.folder / "results/solar_reflex/default/charge").rglob("*.bdf.parquet"))
    assert len(traces) == 4
    for path in traces:
        report = validate_df(pd.read_parquet(path))
        assert report["ok"], report
        assert report["time_stats"]["monotonic"]
        assert not report["legacy_labels"]
