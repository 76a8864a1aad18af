"""The genetic algorithm over strings of integers, on a problem whose optimum is known."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.search.genetic import GeneticSettings, breed, minimise, numbers
from pipeline.search.streams import generators

SETTINGS = GeneticSettings()
TARGET = np.array([3, 1, 4, 1, 5, 9])


def misses(strings: np.ndarray) -> np.ndarray:
    """Squared distance from a target, which the algorithm has to find letter by letter."""
    return np.sum((strings - TARGET) ** 2, axis=1).astype(float)


def run(objective=misses, generations: int = 60, seed: int = 1, replicates: int = 4, settings=SETTINGS):
    return minimise(objective, 20, 6, settings, generations, generators(seed, 0, replicates))


def test_it_finds_the_target_and_never_loses_its_best():
    course = run(generations=300)
    assert np.all(np.diff(course.history.value, axis=1) <= 0.0)
    assert np.all(course.mean >= course.history.value)
    np.testing.assert_array_equal(course.strings(), np.tile(TARGET, (4, 1)))
    np.testing.assert_array_equal(misses(course.strings()), course.history.best_value())


def test_the_same_seed_gives_the_same_history_and_another_another():
    one, again, other = run(), run(), run(seed=2)
    np.testing.assert_array_equal(one.history.position, again.history.position)
    np.testing.assert_array_equal(one.mean, again.mean)
    assert not np.array_equal(one.history.value, other.history.value)


def test_a_population_at_once_is_one_string_at_a_time():
    one_by_one = run(lambda strings: np.concatenate([misses(string[None]) for string in strings]))
    np.testing.assert_array_equal(run().history.position, one_by_one.history.position)


def test_a_replicate_does_not_depend_on_those_beside_it():
    alone = minimise(misses, 20, 6, SETTINGS, 60, generators(1, 2, 1))
    np.testing.assert_array_equal(run().history.value[2], alone.history.value[0])


def test_a_longer_run_begins_as_a_shorter_one():
    np.testing.assert_array_equal(run(generations=90).history.value[:, :61], run().history.value)


def test_evaluations_are_counted_as_they_are_made():
    made = []

    def counted(strings):
        made.append(len(strings))
        return misses(strings)

    course = run(counted, replicates=1, generations=7)
    assert course.history.evaluations[0].tolist() == np.cumsum(made).tolist()
    assert sum(made) == SETTINGS.evaluations(7)


def test_without_crossover_and_mutation_children_are_copies_of_parents():
    still = GeneticSettings(crossover=0.0, mutation=0.0)
    strings = np.arange(20 * 6).reshape(1, 20, 6)
    rand = np.random.default_rng(1).random((1, numbers(still, 6)))
    children = breed(still, 200, strings, rand)[0]
    assert len(children) == 18
    assert {tuple(child) for child in children.tolist()} <= {tuple(string) for string in strings[0].tolist()}


def test_with_crossover_alone_every_gene_comes_from_a_parent_at_its_place():
    crossing = GeneticSettings(crossover=1.0, mutation=0.0)
    strings = np.arange(20 * 6).reshape(1, 20, 6)
    rand = np.random.default_rng(1).random((1, numbers(crossing, 6)))
    children = breed(crossing, 200, strings, rand)[0]
    assert np.all(children % 6 == np.arange(6))
    assert all(len({gene // 6 for gene in child}) <= 2 for child in children.tolist())
    assert any(len({gene // 6 for gene in child}) == 2 for child in children.tolist())


def test_better_strings_have_more_children():
    still = GeneticSettings(population=20, elite=1, crossover=0.0, mutation=0.0)
    strings = np.repeat(np.arange(20), 6).reshape(1, 20, 6)
    rand = np.random.default_rng(1).random((4000, numbers(still, 6)))
    children = breed(still, 200, np.repeat(strings, 4000, axis=0), rand)[:, :, 0]
    share = np.bincount(children.ravel(), minlength=20) / children.size
    expected = 1.0 / np.sqrt(np.arange(1, 21))
    np.testing.assert_allclose(share, expected / expected.sum(), atol=0.002)


def test_an_elite_without_children_is_refused():
    with pytest.raises(ValidationError, match="elite is 20; it must lie below population, 20"):
        GeneticSettings(elite=20)
