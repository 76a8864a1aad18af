"""Traces by the names of the Battery Data Format: those of its ontology, and nothing lost by a reader of today."""

import warnings
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from pipeline.charge.records import Mode
from pipeline.kernel.tables import to_arrow
from tests.charge.samples import battery, charge, load, settings
from tests.making import declared

NAMES = [
    line
    for line in (Path(__file__).parent / "bdf_ontology_1_3_0.txt").read_text().splitlines()
    if not line.startswith("#")
]
CURRENT = {name for name in NAMES if not name.startswith("- ")}
DEPRECATED = {name.removeprefix("- ") for name in NAMES} - CURRENT
TABLE = declared("charge")["trace"].table
OURS = [column.name for column in TABLE.columns if "/" in column.name]


def test_every_column_of_the_format_has_its_name_of_today():
    assert {"Test Time / s", "Voltage / V", "Current / A", "Step Count / 1", "Surface Temperature / degC"} <= set(OURS)
    assert set(OURS) <= CURRENT
    assert not set(OURS) & DEPRECATED
    # What a reader drops or reads as something else: a point within a step, a channel of a logger.
    assert "Step Index / 1" in DEPRECATED
    assert "Surface Temperature T1 / degC" not in CURRENT | DEPRECATED


def test_the_projects_own_columns_are_no_names_of_the_format():
    spoken = {name.split(" / ")[0].lower().replace(" ", "_") for name in CURRENT | DEPRECATED}
    for column in TABLE.columns:
        if "/" not in column.name:
            assert column.name not in spoken, column.name


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    phases = {
        "one": {"constant_current": {"current_a": 2.0}, "until": {"elapsed_s": 35}},
        "two": {"rest": {}, "until": {"elapsed_s": 25}},
    }
    mode = Mode(title="Steps", phases=phases, repeat=2, stop={"elapsed_s": 200.0})
    found = charge(battery("lead_acid_12v7ah"), mode, settings(0.5))
    file = tmp_path_factory.mktemp("bdf") / "trace.bdf.parquet"
    pyarrow.parquet.write_table(to_arrow(TABLE, found.trace), file)
    return found.trace, file


def test_reading_it_loses_nothing(written):
    trace, file = written
    with warnings.catch_warnings():
        # The reader's own imports warn of things in other packages; what it says of the file is an error below.
        warnings.simplefilter("ignore")
        import bdf

        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            read = bdf.read(file)
    assert not [one for one in told if "label" in str(one.message).lower()]
    for column in OURS:
        assert read[column].to_numpy() == pytest.approx(trace[column], rel=1e-15, nan_ok=True), column


def test_a_step_counts_on_over_repeats_and_never_back(written):
    trace, _ = written
    steps = trace["Step Count / 1"]
    assert np.all(np.diff(steps) >= 0)
    assert sorted(set(steps.tolist())) == [1, 2, 3, 4]


def test_the_shipped_modes_write_these_columns():
    sheet = load("modes/cv_reflex.yaml") | {"stop": {"elapsed_s": 2.0}}
    trace = charge(battery("lead_acid_12v7ah"), Mode(**sheet), settings(0.5)).trace
    assert set(trace) == {column.name for column in TABLE.columns}
