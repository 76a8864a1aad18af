"""What the page says of a search beside its tables."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.experiments.frequency.page import notes
from pipeline.experiments.frequency.tuning_tables import OBJECTIVE_NUMBERS
from pipeline.report.tables import ReportData
from tests import making


@pytest.mark.parametrize(
    ("best", "searched", "said"),
    [
        (1.17, (1.0, 500.0), []),
        (1.17, None, []),
        (0.4, (1.0, 500.0), ["is least at 0.4 Hz, outside the 1 Hz to 500 Hz"]),
        (float("nan"), (1.0, 500.0), ["has no least value, outside the 1 Hz to 500 Hz"]),
    ],
)
def test_an_optimum_outside_the_range_is_told(tmp_path: Path, best, searched, said):
    making.output("objective", tmp_path).numbers([OBJECTIVE_NUMBERS.quantity("optimal_frequency_hz", best)])
    labels = {"searched": {} if searched is None else dict(zip(("low", "high"), searched, strict=True))}
    inputs = {"objective": tmp_path, "search": tmp_path}
    found = notes(ReportData(making.inputs(inputs), {}, {}, labels))
    assert len(found) == len(said)
    assert all(part in sentence for part, sentence in zip(said, found, strict=True))
    assert notes(ReportData(making.inputs({"objective": tmp_path}), {}, {}, labels)) == [], "nothing is searched"
