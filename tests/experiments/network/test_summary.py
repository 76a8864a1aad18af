"""The named numbers, where they are more than a minimum or a median."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.experiments.network.comparison import Result, Size
from pipeline.experiments.network.summary import of_sizes, uncovered
from pipeline.grnn.error import Form
from pipeline.grnn.selection.problem import Selected


def numbers(errors: list[float], forward: list[float]) -> dict[str, float]:
    found = [
        Size(count + 2, (0.1, 1.0), np.array([error, error, 9.0]), other)
        for count, (error, other) in enumerate(zip(errors, forward, strict=True))
    ]
    return {one.name: one.value for one in of_sizes(found, 0.05)}


@pytest.mark.parametrize(
    ("errors", "forward", "printed", "best", "sooner"),
    [
        ([0.4, 0.1, 0.04, 0.06], [0.5, 0.1, 0.05, 0.05], 4, 4, 5),
        ([0.4, 0.3, 0.2, 0.1], [0.3, 0.2, 0.1, 0.05], np.nan, 5, 2),
        ([0.4, 1e-20, 1e-22, 1e-21], [0.5, 1e-18, 1e-19, 1e-20], 3, 3, 3),
        ([0.4, 0.3, 0.2, 0.1], [0.5, 0.1, 0.1, 0.2], np.nan, 5, np.nan),
    ],
)
def test_sizes_in_numbers(errors, forward, printed, best, sooner):
    found = numbers(errors, forward)
    keys = ("smallest_size_at_printed", "best_size", "forward_as_good_from")
    assert [found[key] for key in keys] == pytest.approx([printed, best, sooner], nan_ok=True)
    assert (found["size_3_mse"], found["size_3_forward_mse"], found["size_3_units"]) == (errors[1], forward[1], 7)


def test_what_no_support_reaches_is_counted(surfaces):
    data = surfaces["plateau_ramp"]
    # A centre at 25 degC with a support of 5 K and any gradient reaches 21 to 29 degC.
    rows = np.array([[np.flatnonzero((data.inputs == [25.0, 0.5]).all(axis=1))[0]]])
    result = Result(Form("wendland", (0.1, 1e6)), [], Selected(rows, np.zeros(1), 1))
    assert uncovered(data, result) == pytest.approx(1.0 - 9.0 / 51.0)
