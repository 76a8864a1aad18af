"""The paper's own tables, and the analysis of variance against least squares and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import f_oneway

from pipeline.taguchi.analysis import anova, chosen_levels, level_sums, predicted, rank, run_at, signal_to_noise_db
from pipeline.taguchi.arrays import full_factorial, standard

NAMES = ("c1", "c2", "w")


def least_squares_rest(array, values):
    """Return the residual sum of squares of the additive model, by least squares on indicator columns."""
    columns = [np.ones(len(values))]
    for factor in array.T:
        columns += [(factor == level).astype(float) for level in range(1, factor.max() + 1)]
    matrix = np.stack(columns, axis=1)
    fitted = matrix @ np.linalg.lstsq(matrix, values, rcond=None)[0]
    return float(np.sum((values - fitted) ** 2)), fitted


def test_table_3_is_the_level_sums_of_table_2(array, table_2, table_3):
    for name, sums in zip(NAMES, level_sums(array, table_2["ise"]), strict=True):
        assert np.round(sums, 4).tolist() == table_3[name].tolist()
        assert sums.sum() == pytest.approx(231.8254, abs=1e-9)


def test_the_paper_chooses_a_run_it_has_already_made(array, table_2):
    ise = table_2["ise"]
    chosen = chosen_levels(array, ise)
    assert chosen.tolist() == [1, 1, 2]
    run = run_at(array, chosen)
    assert run == 5
    assert rank(ise, run) == 8
    assert int(np.argmin(ise)) == 2
    assert predicted(array, ise, chosen) == pytest.approx(13.1001, abs=1e-4)
    assert ise[run] - predicted(array, ise, chosen) == pytest.approx(1.1957, abs=1e-4)
    assert np.argmax([np.sum(signal_to_noise_db(ise)[array[:, 0] == level]) for level in range(4)]) == 1


def test_variance_of_table_2_is_noise(array, table_2):
    found = anova(NAMES, array, table_2["ise"])
    assert [round(row.sum_of_squares, 3) for row in found.factors] == [2.958, 1.292, 1.545]
    assert [round(row.f, 2) for row in found.factors] == [0.66, 0.29, 0.35]
    assert [round(row.p, 2) for row in found.factors] == [0.60, 0.83, 0.79]
    assert round(found.error.sum_of_squares, 3) == 8.912
    assert found.error.degrees_of_freedom == 6
    assert (round(found.model.f, 2), round(found.model.p, 2)) == (0.43, 0.87)
    assert round(found.explained_share, 2) == 0.39
    assert [row.name for row in found.rows()] == [*NAMES, "all factors", "error", "total"]


@pytest.mark.parametrize("replicates", [1, 4])
def test_variance_is_that_of_least_squares(array, replicates):
    values = np.random.default_rng(1).normal(size=(16, replicates)) + array[:, :1] * 0.5
    found = anova(NAMES, array, values)
    long = np.repeat(array, replicates, axis=0)
    rest, _ = least_squares_rest(long, values.ravel())
    assert found.error.sum_of_squares == pytest.approx(rest, rel=1e-10)
    assert found.error.degrees_of_freedom == 16 * replicates - 10
    assert found.residual_deviation == pytest.approx(np.sqrt(rest / (16 * replicates - 10)))
    for index, row in enumerate(found.factors):
        without, _ = least_squares_rest(np.delete(long, index, axis=1), values.ravel())
        assert row.sum_of_squares == pytest.approx(without - rest, rel=1e-9)


def test_one_factor_is_the_one_way_test():
    values = np.random.default_rng(2).normal(size=(3, 7)) + np.array([[0.0], [0.5], [1.0]])
    found = anova(("a",), np.arange(3)[:, None], values)
    expected = f_oneway(*values)
    assert found.factors[0].f == pytest.approx(expected.statistic)
    assert found.factors[0].p == pytest.approx(expected.pvalue)


def test_a_saturated_design_has_no_test():
    found = anova(("a", "b", "c"), standard("L4(2^3)", [2, 2, 2]), np.array([1.0, 2.0, 4.0, 3.0]))
    assert found.error.degrees_of_freedom == 0
    assert all(np.isnan(row.f) and np.isnan(row.p) for row in found.factors)


def test_prediction_is_that_of_least_squares_and_exact_for_an_additive_response(array, table_2):
    _, fitted = least_squares_rest(array, table_2["ise"])
    for levels, value in zip(array, fitted, strict=True):
        assert predicted(array, table_2["ise"], levels) == pytest.approx(value, rel=1e-12)
    effects = np.random.default_rng(3).normal(size=(3, 4))

    def response(levels):
        return 7.0 + sum(effects[factor, levels[:, factor]] for factor in range(3))

    everything = full_factorial((4, 4, 4))
    for levels, value in zip(everything, response(everything), strict=True):
        assert predicted(array, response(array), levels) == pytest.approx(value, rel=1e-9)
    assert chosen_levels(array, response(array)).tolist() == np.argmin(effects, axis=1).tolist()


def test_signal_to_noise_of_replicates():
    assert signal_to_noise_db(np.array([10.0, 1.0])).tolist() == [-20.0, 0.0]
    assert signal_to_noise_db(np.array([[3.0, 4.0]]))[0] == pytest.approx(-10 * np.log10(12.5))


def test_several_sets_of_results_are_chosen_from_together(array):
    values = np.random.default_rng(4).normal(size=(16, 9))
    together = chosen_levels(array, values)
    assert together.shape == (9, 3)
    for index in range(9):
        assert together[index].tolist() == chosen_levels(array, values[:, index]).tolist()


def test_a_combination_that_was_not_run_has_no_run(array):
    assert run_at(array, np.array([0, 0, 0])) == 0
    assert run_at(array, np.array([0, 0, 1])) is None
