"""What planning tells a person before anything runs."""

from __future__ import annotations

from pathlib import Path

import pvlib

from pipeline.config.planning import make_plan, run_of

FILE = Path(pvlib.__file__).parent / "data" / "703165TY.csv"


def test_a_study_without_files_tells_of_none() -> None:
    assert not any("taken for" in line or "not given" in line for line in run_of(["study=solar_reflex"]).remarks)


def test_the_plan_tells_what_a_file_was_taken_for_and_which_values_are_usual_ones() -> None:
    words = [
        "study=solar_reflex",
        "weather@day.weathers.clear=measured",
        f"day.weathers.clear.file={FILE}",
        "day.weathers.clear.date=2015-06-21",
        "day.weathers.clear.surface={tilt_deg: 30, azimuth_deg: 180, albedo: 0.2}",
        "~panel.cells_in_series",
    ]
    (run,) = make_plan([words])["runs"]
    assert "day.weathers.clear: taken for TMY3, read by pvlib" in run["remarks"]
    assert any(line.startswith("panel.cells_in_series: 36, not given: usual for") for line in run["remarks"])
    assert run["sources"]["panel.cells_in_series"]["kind"] == "estimate"
