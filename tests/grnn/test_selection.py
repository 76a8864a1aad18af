"""The selections: each against what it should be, all on one number of evaluations."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from pipeline.grnn.error import Form
from pipeline.grnn.records import data_of
from pipeline.grnn.selection import genetic, greedy
from pipeline.grnn.selection.baselines import regular
from pipeline.grnn.selection.least_squares import orthogonal
from pipeline.grnn.selection.medoids import medoids
from pipeline.grnn.selection.methods import SELECT, Task, trials
from pipeline.grnn.selection.problem import problem_of
from pipeline.search.genetic import GeneticSettings
from pipeline.search.streams import generators

GENETIC = GeneticSettings()


def problem(data, widths=(0.1, 10.0), centres=6, generations=320, kernel="extendable"):
    return problem_of(data, Form(kernel, widths), centres, GENETIC, generations)


@pytest.mark.parametrize(("surface", "widths"), [("plateau_steps", (0.05, 3.0)), ("sigmoid", (0.2, 3.0))])
def test_six_centres_learn_a_surface_as_well_as_the_paper_says(surfaces, surface, widths):
    selected = genetic.select(problem(surfaces[surface], widths), generators(1, 0, 8))
    assert np.min(selected.error) < 0.01


@pytest.mark.parametrize("method", SELECT)
def test_a_selection_is_what_it_says(surfaces, method):
    data = surfaces["plateau_ramp"]
    task = problem(data, generations=200)
    selected, again = (SELECT[method](task, generators(7, 0, 3)) for _ in range(2))
    assert selected.rows.shape[1] == 6
    assert selected.rows.min() >= 0
    assert selected.rows.max() < len(data.rate)
    np.testing.assert_array_equal(selected.error, task.errors(selected.rows))
    np.testing.assert_array_equal(selected.rows, again.rows)
    assert selected.evaluations <= task.evaluations
    assert selected.error.min() == task.errors(selected.best()[None])[0]


@pytest.mark.parametrize("method", ["genetic", "exchange", "random_best", "medoids", "random"])
def test_a_replicate_does_not_depend_on_those_beside_it(surfaces, method):
    task = problem(surfaces["plateau_ramp"], generations=30)
    together = SELECT[method](task, generators(3, 0, 3))
    alone = SELECT[method](task, generators(3, 1, 1))
    np.testing.assert_array_equal(together.rows[1], alone.rows[0])


def test_greedy_finds_the_best_pair_of_a_small_table():
    rng = np.random.default_rng(5)
    inputs = rng.uniform([0.0, 0.0], [50.0, 1.0], size=(12, 2))
    data = data_of(inputs[:, 0], inputs[:, 1], 8.0 / (1.0 + np.exp(inputs[:, 0] - 25.0)), 60.0)
    task = problem(data, (0.2, 1.0), centres=2, generations=50)
    pairs = np.array(list(combinations(range(12), 2)))
    best = pairs[np.argmin(task.errors(pairs))]
    assert sorted(greedy.select(task, [])[0][0]) == sorted(best)
    rows, error = greedy.forward(task)
    np.testing.assert_array_equal(error, [task.errors(rows[None, :count])[0] for count in (1, 2)])


def test_orthogonal_least_squares_is_stepwise_regression():
    rng = np.random.default_rng(3)
    columns, wanted = rng.normal(size=(40, 8)), rng.normal(size=40)
    found = orthogonal(columns, wanted, 4)
    chosen: list[int] = []
    for row, error in zip(found.rows, found.error, strict=True):
        left = {}
        for other in set(range(8)) - set(chosen):
            design = np.column_stack([np.ones(40), columns[:, [*chosen, other]]])
            rest = wanted - design @ np.linalg.lstsq(design, wanted, rcond=None)[0]
            left[other] = np.mean(rest**2)
        chosen.append(min(left, key=left.get))
        assert row == chosen[-1]
        assert error == pytest.approx(left[row])


def test_orthogonal_least_squares_goes_on_where_no_column_is_new():
    found = orthogonal(np.ones((5, 3)), np.arange(5.0), 3)
    assert found.rows.tolist() == [0, 1, 2]
    assert np.all(np.isfinite(found.error))


def test_medoids_are_the_middles_of_plain_clusters():
    place = np.array([0.0, 0.1, 0.2, 10.0, 10.1, 10.2, 10.3, 10.4])
    distance = np.abs(place[:, None] - place[None])
    for seed in range(20):
        rows = medoids(distance, 2, np.random.default_rng(seed))
        cluster = np.argmin(distance[rows], axis=0)
        for number, row in enumerate(rows):
            members = np.flatnonzero(cluster == number)
            assert np.sum(distance[row, members]) == np.min(np.sum(distance[np.ix_(members, members)], axis=1))
    assert any(medoids(distance, 2, np.random.default_rng(seed)).tolist() == [1, 5] for seed in range(20))


def test_regular_rows_are_the_middles_of_rectangles(surfaces):
    inputs = surfaces["plateau_ramp"].inputs
    rows = inputs[regular(inputs, 6)]
    assert sorted({temperature for temperature, _ in rows.tolist()}) == [8.0, 25.0, 42.0]
    assert len(set(map(tuple, rows.tolist()))) == 6
    # A prime number of rectangles lies along the temperature.
    assert len(np.unique(inputs[regular(inputs, 7), 0])) == 7
    assert inputs[regular(inputs, 1)].tolist() == [[25.0, 0.5]]


def test_too_many_centres_are_refused(surfaces):
    with pytest.raises(ValueError, match="562 centres of 561 points"):
        problem(surfaces["sigmoid"], centres=562)


def test_the_best_widths_come_first_and_no_trial_is_a_replicate(study, surfaces):
    widths = study.form.widths.model_copy(update={"temperature": (0.01, 0.1), "gradient": (10.0,), "finalists": 1})
    task = Task(surfaces["plateau_ramp"], "extendable", 2.0, 6, GENETIC)
    found = trials("random_best", task, widths, 60, 1)
    assert {one.widths for one in found} == {(0.01, 10.0), (0.1, 10.0)}
    own = SELECT["random_best"](task.problem(found[0].widths, 60), generators(1, 0, widths.trial_replicates))
    assert found[0].error not in own.error
