"""A small study of searches on test functions, and its statistics against scipy and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.stats import friedmanchisquare, wilcoxon

from pipeline.experiments.functions.functions import loops, quantities
from pipeline.experiments.functions.numbers import VOCABULARY, fields
from pipeline.experiments.functions.statistics import (
    Runs,
    contests,
    friedman,
    holm,
    ranks,
    run,
    signed_rank,
    speedup,
    statistics,
)
from pipeline.search.benchmark_functions import BENCHMARKS, problem
from pipeline.search.function_records import HALF_WIDTHS, FunctionStudy
from pipeline.search.registry import replicated

VALUES = {
    "dimensions": 4,
    "functions": ["sphere", "rastrigin", "ackley"],
    "shift_share": 0.4,
    "threshold": 1e-6,
    "plain": "cuckoo",
    "variants": {
        "replicates": 6,
        "shared": {"kind": "cuckoo", "nests": 10, "generations": 150},
        "searches": {"cuckoo": {}, "inertia": {"inertia": 0.9, "inertia_end": 0.4}, "integral": {"ki": 0.05}},
    },
    "baselines": {
        "replicates": 3,
        "searches": {
            "differential_evolution": {"kind": "differential_evolution", "population": 20, "generations": 20},
        },
    },
}


def study(**changes):
    return FunctionStudy(**{**VALUES, **changes})


@pytest.fixture(scope="module")
def found():
    return {name: list(run(study(), name, 3)) for name in VALUES["functions"]}


@pytest.fixture(scope="module")
def runs(found):
    return [one for pairs in found.values() for one, _ in pairs]


def row_of(rows, search, function, placement):
    (row,) = [one for one in rows if (one.search, one.function, one.placement) == (search, function, placement)]
    return row


def test_every_search_runs_on_every_function_in_every_placement(runs):
    assert len(runs) == len({(one.search, one.function, one.placement) for one in runs}) == 4 * 3 * 3
    for one in runs:
        assert len(one.value) == (3 if one.search == "differential_evolution" else 6)
        assert np.all(one.value <= one.value_at_budget)


def test_runs_are_those_of_the_search_alone(runs):
    where = problem("rastrigin", "rotated", 4, 0.4, 3)
    settings = study().searches(HALF_WIDTHS["rastrigin"])["integral"]
    history = replicated(where.objective, settings, 3)
    one = row_of(runs, "integral", "rastrigin", "rotated")
    np.testing.assert_array_equal(one.value, history.best_value())
    affordable = history.evaluations[0] <= 420
    np.testing.assert_array_equal(one.value_at_budget, history.value[:, affordable][:, -1])
    for replicate, generations in enumerate(one.generations):
        below = np.flatnonzero(history.value[replicate] <= 1e-6)
        assert generations == (below[0] if len(below) else np.inf)


def test_a_perfect_score_is_lost_when_the_minimum_leaves_the_origin(runs):
    rows = statistics(runs)
    assert row_of(rows, "inertia", "sphere", "centred").mean < 1e-20
    assert row_of(rows, "inertia", "sphere", "shifted").mean > 1e-12
    centred, shifted = (row_of(rows, "integral", "sphere", place).generations for place in ("centred", "shifted"))
    assert centred == pytest.approx(shifted, rel=0.3), "the integral has no such bias"


def test_curves_end_where_the_runs_do(found):
    for pairs in found.values():
        for one, curve in pairs:
            assert curve.generation[0] == 0
            assert curve.evaluations[-1] == one.spent.mean()
            assert curve.median[-1] == np.median(one.value)
            assert np.all(np.diff(curve.mean) <= 0.0)


def test_quantities_have_the_names_that_are_promised(runs):
    rows = statistics(runs)
    chosen = study()
    variants = list(chosen.variants.searches)
    numbers = quantities(chosen, rows, contests(runs, "cuckoo", variants), ranks(rows, variants))
    numbers += loops(chosen, 3)
    listed = [one.name for one in numbers]
    assert sorted(listed) == sorted(VOCABULARY.names(fields(chosen)))
    by_name = {one.name: one.value for one in numbers}
    assert by_name["cuckoo_loop_error"] == 0.0, "plain search has no error for an integral to remove"
    kp = by_name["kp_median"]
    assert by_name["inertia_loop_error"] == pytest.approx(0.35 / (0.35 + kp))
    assert (by_name["integral_loop_error"], by_name["integral_loop_stable"]) == (0.0, 1.0)
    assert by_name["kp_negative_share"] == pytest.approx(0.5, abs=0.01)
    assert by_name["budget"] == 420.0
    assert by_name["inertia_sphere_centred_mean"] == row_of(rows, "inertia", "sphere", "centred").mean
    shares = [row_of(rows, "cuckoo", name, "shifted").success_share for name in VALUES["functions"]]
    assert by_name["cuckoo_shifted_mean_success_share"] == pytest.approx(np.mean(shares))
    assert by_name["inertia_centred_value_better"] + by_name["inertia_centred_value_worse"] <= 3


def test_a_study_whose_plain_search_is_no_cuckoo_search_has_no_loops():
    variants = VALUES["variants"] | {"shared": {}, "searches": {
        "cuckoo": {"kind": "differential_evolution", "population": 20, "generations": 20}}}  # fmt: skip
    chosen = study(variants=variants, baselines=None)
    assert loops(chosen, 3) == []
    assert not any("loop" in name or name.startswith("kp_") for name in VOCABULARY.names(fields(chosen)))


def made(search, function, values, generations):
    values, generations = np.array(values), np.array(generations)
    spent = np.full(len(values), 500.0)
    return Runs(function, "centred", search, values, values, generations, 50.0 * generations, spent)


def test_statistics_by_hand():
    (row,) = statistics([made("a", "sphere", [1.0, 3.0, 0.0], [np.inf, np.inf, 4.0])])
    assert (row.mean, row.median, row.best, row.success_share) == (pytest.approx(4 / 3), 1.0, 0.0, pytest.approx(1 / 3))
    assert row.deviation == pytest.approx(np.std([1, 3, 0], ddof=1))
    assert (row.generations, row.evaluations) == (4.0, 200.0)
    assert np.isnan(row.generations_deviation)
    (never,) = statistics([made("a", "sphere", [1.0, 2.0], [np.inf, np.inf])])
    assert np.isnan(never.generations)


def test_speedup_counts_functions_that_both_always_solve():
    rows = {
        search: {
            row.function: row
            for row in statistics([
                made(search, "sphere", [0.0, 0.0], [10.0 * factor, 10.0 * factor]),
                made(search, "ackley", [0.0, 0.0], [90.0, 90.0]),
                made(search, "rastrigin", [0.0, 1.0], [1.0, np.inf]),
            ])
        }
        for search, factor in (("plain", 4.0), ("fast", 1.0))
    }  # fmt: skip
    assert speedup(rows["fast"], rows["plain"]) == pytest.approx(2.0)
    assert np.isnan(speedup({"rastrigin": rows["fast"]["rastrigin"]}, rows["plain"]))


def test_better_and_worse_follow_the_sign():
    rng = np.random.default_rng(1)
    base = rng.random(20)
    runs = [made("plain", "sphere", base, 10.0 + base), made("other", "sphere", base - 1.0, 20.0 + base)]
    found = {one.measure: one for one in contests(runs, "plain", ["plain", "other"])}
    assert (found["value"].better, found["value"].worse) == (True, False)
    assert (found["generations"].better, found["generations"].worse) == (False, True)


def test_signed_ranks_against_scipys_exact_test():
    rng = np.random.default_rng(2)
    first = rng.normal(size=15)
    second = first + rng.normal(0.4, 1.0, 15)
    assert signed_rank(first, second) == pytest.approx(wilcoxon(first, second, method="exact").pvalue)
    # With ties and zeros: Pratt's normal approximation.
    rough = np.round(second)
    expected = wilcoxon(np.round(first), rough, zero_method="pratt", method="approx", correction=True)
    assert signed_rank(np.round(first), rough) == pytest.approx(expected.pvalue)
    assert signed_rank(first, first) == 1.0


def test_friedman_against_scipy_also_with_ties():
    rng = np.random.default_rng(3)
    for table in (rng.random((7, 4)), rng.integers(0, 3, (9, 4)).astype(float)):
        mean, p = friedman(table)
        assert p == pytest.approx(friedmanchisquare(*table.T).pvalue)
        assert mean.sum() == pytest.approx(10.0)
    assert friedman(np.ones((5, 3)))[1] == 1.0


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.6, 0.9]) == [1.0, 1.0]


@pytest.mark.parametrize("name", BENCHMARKS)
@pytest.mark.parametrize("placement", ["centred", "shifted", "rotated"])
def test_a_problem_has_its_minimum_where_it_says(name, placement):
    where = problem(name, placement, 5, 0.4, 7)
    assert where.objective(where.minimum_at[None])[0] == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.abs(where.minimum_at) <= (1.0 if name == "rosenbrock" and placement == "centred" else np.inf))
    assert np.all((where.box.low <= where.minimum_at) & (where.minimum_at <= where.box.high))
    others = np.random.default_rng(1).uniform(where.box.low, where.box.high, (200, 5))
    assert np.all(where.objective(others) > 0.0)
    if placement != "centred":
        assert np.all(np.abs(where.minimum_at) <= 0.4 * where.box.high)
        assert np.abs(where.minimum_at).max() > 0.05 * where.box.high[0]
    np.testing.assert_array_equal(problem(name, placement, 5, 0.4, 7).minimum_at, where.minimum_at)
    assert placement == "centred" or np.any(problem(name, placement, 5, 0.4, 8).minimum_at != where.minimum_at)


def test_a_value_does_not_depend_on_its_neighbours():
    where = problem("griewank", "rotated", 10, 0.4, 1)
    population = np.random.default_rng(1).uniform(where.box.low, where.box.high, (750, 10))
    together = where.objective(population)
    np.testing.assert_array_equal(together[[3, 400, 749]], where.objective(population[[3, 400, 749]]))
    assert together[12] == where.objective(population[12:13])[0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"functions": ["sphere", "spere"]}, "no test function 'spere'; best matches are: sphere"),
        ({"functions": ["sphere", "sphere"]}, "each may stand there once"),
        ({"placements": []}, "placements is empty"),
        ({"plain": "cucko"}, "plain is 'cucko', no variant; best matches are: cuckoo"),
        ({"baselines": VALUES["variants"]}, "both a variant and a baseline"),
        ({"variants": VALUES["variants"] | {"searches": {"cuckoo": {"nest": 3}}}}, "nest"),
        (
            {"variants": VALUES["variants"] | {"searches": {"cuckoo": {"kind": "cucko"}}}},
            "no search algorithm 'cucko'",
        ),
    ],
)
def test_mistakes_are_named(changes, message):
    with pytest.raises(ValidationError, match=message):
        study(**changes)
