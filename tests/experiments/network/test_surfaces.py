"""The surfaces: their formulas, the grid of the paper, and what its Table II allows."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.experiments.network.records import PlateauRamp, PlateauSteps
from pipeline.experiments.network.sources import Printed, agreements, printed_rows, rate
from pipeline.grnn.records import data_of


def test_the_grid_is_the_papers_and_holds_every_legible_row(surfaces):
    inputs = surfaces["plateau_steps"].inputs
    assert len(inputs) == 561
    assert len(np.unique(inputs[:, 0])) == 51
    points = set(map(tuple, inputs.tolist()))
    rows = printed_rows()
    assert [row.row for row in rows] == [1, 3, 4, 5]
    assert all((row.temperature_c, row.gradient) in points for row in rows)


@pytest.mark.parametrize(
    ("name", "temperature", "gradient", "expected"),
    [
        ("plateau_steps", [41.0, 42.0, 46.0, 47.0], 0.5, [8.0, 2.0, 2.0, 0.1]),
        ("plateau_ramp", [10.0, 41.0, 43.0, 46.5, 60.0], 0.5, [8.0, 6.0, 2.0, 1.05, 0.1]),
        ("sigmoid", [42.0, 40.0, -5e5], 0.0, [0.1 + 7.9 / 2, 0.1 + 7.9 / (1 + np.exp(-2.0)), 8.0]),
        ("sigmoid", [40.0], 1.0, [0.1 + 7.9 / 2]),
        ("takagi_sugeno", [0.0, 12.5, 37.5, 50.0], 0.0, [8.0, 8.0, 5.0, 2.0]),
        ("takagi_sugeno", [0.0, 37.5, 50.0], 0.5, [6.0, (6.0 + 1.05) / 2, 1.05]),
    ],
)
def test_a_surface_is_its_formula(study, name, temperature, gradient, expected):
    found = rate(getattr(study.data.surfaces, name), np.array(temperature), np.full(len(temperature), gradient))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_two_surfaces_agree_with_the_legible_rows(study):
    found = agreements(study.data, printed_rows())
    agree = {one.surface: all(other.consistent for other in found if other.surface == one.surface) for one in found}
    assert agree == {"plateau_steps": True, "plateau_ramp": True, "sigmoid": False, "takagi_sugeno": False}


def test_a_row_agrees_as_far_as_it_is_rounded(study):
    by_half = [Printed(1, 50.0, 0.0, rate, "") for rate in (0.6, 0.7)]
    found = [one for one in agreements(study.data, by_half) if one.surface == "plateau_ramp"]
    assert [one.consistent for one in found] == [True, False]


def test_records_that_do_not_fit_are_refused():
    with pytest.raises(ValidationError, match="edges_c has 1 entries; 3 rates"):
        PlateauSteps(rates_c=(8.0, 2.0, 0.1), edges_c=(40.0,))
    with pytest.raises(ValidationError, match="must lie above the one before"):
        PlateauRamp(temperatures_c=(40.0, 40.0), rates_c=(8.0, 2.0))


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (([1.0, 2.0], [0.1, np.nan], [1.0, 1.0]), "row 2: gradient is nan"),
        (([1.0, 2.0], [0.1, 0.2], [1.0, -1.0]), "row 2: rate_c is -1; a charging rate is 0 or more"),
        (([1.0, 1.0], [0.1, 0.1], [1.0, 1.0]), "row 1.*more than once"),
        (([1.0], [0.1], [1.0]), "1 points; allowed are 2 or more"),
        (([1.0, 2.0], [0.1], [1.0, 1.0]), "one length for all"),
    ],
)
def test_data_that_are_none_are_refused(columns, message):
    with pytest.raises(ValueError, match=message):
        data_of(*columns, 60.0)
