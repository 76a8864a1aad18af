from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.errors import UserError
from pipeline.taguchi.arrays import (
    Design,
    factor_values,
    full_factorial,
    index_in_factorial,
    is_orthogonal,
    rows,
    standard,
)

STANDARD = {"L4(2^3)": [2, 2, 2], "L8(2^7)": [2] * 7, "L9(3^4)": [3] * 4, "L16(4^5)": [4] * 5, "L25(5^6)": [5] * 6,
            "L27(2^1 3^12)": [3] * 9}  # fmt: skip


def test_the_published_design_is_table_2_run_by_run(design, array, table_2):
    found = factor_values(design, array)
    for name in ("c1", "c2", "w"):
        np.testing.assert_array_equal(found[name], table_2[name])


def test_the_published_array_is_orthogonal_but_not_the_standard_one(array):
    assert is_orthogonal(array)
    expected = standard("L16(4^5)", [4, 4, 4])
    assert (np.flatnonzero((array != expected).any(axis=1)) + 1).tolist() == [6, 8, 14, 16]
    np.testing.assert_array_equal(array[:, :2], expected[:, :2])


@pytest.mark.parametrize("name", STANDARD)
def test_standard_arrays_are_orthogonal(name):
    found = standard(name, STANDARD[name])
    assert found.shape[1] == len(STANDARD[name])
    assert found.min() == 0
    assert (found.max(axis=0) + 1).tolist() == STANDARD[name]
    assert is_orthogonal(found)


def test_one_changed_level_breaks_orthogonality(array):
    for run, factor in ((0, 0), (7, 1), (15, 2)):
        changed = array.copy()
        changed[run, factor] = (changed[run, factor] + 1) % 4
        assert not is_orthogonal(changed)


def test_a_design_may_name_a_standard_array(design):
    named = design.model_copy(update={"array": "L16(4^5)"})
    np.testing.assert_array_equal(rows(named), standard("L16(4^5)", [4, 4, 4]))


def test_arrays_that_do_not_exist_or_do_not_fit_are_refused():
    with pytest.raises(UserError, match=r"no standard array 'L16\(4\^4\)'; best matches are: .*L16\(4\^5\)"):
        standard("L16(4^4)", [4, 4])
    with pytest.raises(UserError, match=r"L9\(3\^4\) has no columns for factors of \[3, 4\] levels"):
        standard("L9(3^4)", [3, 4])


def test_full_factorial_holds_every_combination_once(array):
    combinations = full_factorial((4, 4, 4))
    assert combinations.shape == (64, 3)
    assert len({tuple(row) for row in combinations}) == 64
    assert is_orthogonal(combinations)
    np.testing.assert_array_equal(index_in_factorial(combinations, (4, 4, 4)), np.arange(64))
    np.testing.assert_array_equal(combinations[index_in_factorial(array, (4, 4, 4))], array)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"array": [[1, 2]]}, "array row 1 has 2 entries; the design has 3 factors"),
        ({"array": [[1, 1, 1], [1, 5, 1]]}, "array row 2 has level 5 of c2; its levels are 1 to 4"),
        ({"factors": {"c1": [0.5, 0.5]}, "array": [[1]]}, "it must hold two or more levels, all different"),
    ],
)
def test_impossible_designs_are_refused(design, change, message):
    with pytest.raises(ValidationError, match=message):
        Design(**{**design.model_dump(), **change})
