"""Every search on every function, from two lists; the functions against their definitions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import rosen

from pipeline.search.benchmark_functions import BENCHMARKS, random_rotation, rotated, shifted
from pipeline.search.box import History
from pipeline.search.registry import replicated, settings_from

_SWARM = {
    "kind": "swarm", "title": "swarm", "particles": 30, "iterations": 150, "replicates": 3, "c1": 1.5, "c2": 1.5,
    "w": 0.7, "velocity_limit": 0.5, "position_limit": "clamp",
}  # fmt: skip
_CUCKOO = {"kind": "cuckoo", "title": "cuckoo", "nests": 15, "generations": 400, "replicates": 3}
_POPULATION = {"title": "baseline", "population": 30, "generations": 100, "replicates": 2}
SEARCHES = {
    "swarm, uniform": {**_SWARM, "rand": "uniform"},
    "swarm, logistic": {**_SWARM, "rand": "logistic"},
    "swarm, arcsine": {**_SWARM, "rand": "arcsine"},
    "cuckoo": _CUCKOO,
    "cuckoo, inertia": {**_CUCKOO, "inertia": 0.9, "inertia_end": 0.4},
    "cuckoo, integral": {**_CUCKOO, "ki": 0.05},
    "differential evolution": {**_POPULATION, "kind": "differential_evolution"},
    "genetic": {**_POPULATION, "kind": "genetic", "generations": 150},
    "particle swarm": {**_POPULATION, "kind": "particle_swarm", "generations": 60},
    "sweep": {"kind": "sweep", "title": "sweep", "points": 101, "refinements": 4, "replicates": 2},
}
FUNCTIONS = {
    "sphere": 1e-6,
    "rastrigin": 1e-3,
    "rosenbrock": 1e-2,
    "ackley": 1e-2,
    "griewank": 0.03,
    "schwefel_222": 1e-2,
    "schwefel_12": 1e-2,
}


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(
    "search",
    # Steps of a population in Python: three seconds a function.
    [pytest.param(name, marks=pytest.mark.slow) if name == "genetic" else name for name in SEARCHES],
)
def test_every_search_finds_the_minimum_of_every_function(search, function):
    benchmark = BENCHMARKS[function]
    # Off the centre, so that neither a start in the middle nor an odd grid hits it by chance.
    offset = 0.0437 * benchmark.half_width * np.array([1.0, -0.7])
    edge = {"low": -benchmark.half_width, "high": benchmark.half_width}
    settings = settings_from({**SEARCHES[search], "variables": {"x": edge, "y": edge}})
    history = replicated(shifted(benchmark, offset), settings, 5)
    assert isinstance(history, History)
    assert np.median(history.best_value()) < FUNCTIONS[function]
    assert np.all(np.diff(history.value, axis=1) <= 0.0)
    assert np.all(np.diff(history.evaluations, axis=1) >= 0)
    assert np.all(np.abs(history.position) <= benchmark.half_width)
    np.testing.assert_array_equal(replicated(shifted(benchmark, offset), settings, 5).position, history.position)


@pytest.mark.parametrize("dimensions", [1, 2, 7])
@pytest.mark.parametrize("benchmark", BENCHMARKS.values(), ids=lambda benchmark: benchmark.name)
def test_minimum_is_zero_and_where_it_is_said_to_be(benchmark, dimensions):
    best = np.full((1, dimensions), benchmark.minimum_at)
    assert benchmark.function(best)[0] == pytest.approx(0.0, abs=1e-12)
    rng = np.random.default_rng(1)
    box = benchmark.box(dimensions)
    others = rng.uniform(box.low, box.high, (500, dimensions))
    assert np.all(benchmark.function(others) > 0.0)
    near = best + 1e-3 * rng.standard_normal((100, dimensions))
    assert np.all(benchmark.function(near) > 0.0)


@pytest.mark.parametrize("benchmark", BENCHMARKS.values(), ids=lambda benchmark: benchmark.name)
def test_a_population_at_once_is_one_by_one(benchmark):
    population = np.random.default_rng(2).uniform(-2.0, 2.0, (20, 4))
    one_by_one = [benchmark.function(row[None, :])[0] for row in population]
    np.testing.assert_allclose(benchmark.function(population), one_by_one, rtol=1e-13)


def test_values_at_known_points():
    point = np.array([[1.0, 2.0, -0.5]])
    expected = {
        "sphere": 5.25,
        "rastrigin": 5.25 + 10.0 * (1 - 1) + 10.0 * (1 - 1) + 10.0 * 2,
        "rosenbrock": rosen(point[0]),
        "griewank": 5.25 / 4000 - np.cos(1.0) * np.cos(2.0 / np.sqrt(2)) * np.cos(-0.5 / np.sqrt(3)) + 1,
        "schwefel_222": 3.5 + 1.0,
        "schwefel_12": 1.0**2 + 3.0**2 + 2.5**2,
        "ackley": -20 * np.exp(-0.2 * np.sqrt(5.25 / 3)) - np.exp((1 + 1 - 1) / 3) + 20 + np.e,
    }
    assert set(expected) == set(BENCHMARKS)
    for name, value in expected.items():
        assert BENCHMARKS[name].function(point)[0] == pytest.approx(value, rel=1e-12), name


def test_shift_and_rotation_move_the_minimum_and_keep_the_shape():
    offset = np.array([0.3, -0.2, 0.1])
    rotation = random_rotation(3, np.random.default_rng(3))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    points = np.random.default_rng(4).uniform(-1.0, 1.0, (50, 3))
    for benchmark in BENCHMARKS.values():
        best = np.full((1, 3), benchmark.minimum_at)
        assert shifted(benchmark, offset)(best + offset)[0] == pytest.approx(0.0, abs=1e-12)
        assert rotated(benchmark, rotation)(best)[0] == pytest.approx(0.0, abs=1e-12)
    sphere, rosenbrock = BENCHMARKS["sphere"], BENCHMARKS["rosenbrock"]
    np.testing.assert_allclose(rotated(sphere, rotation)(points), sphere.function(points), rtol=1e-12)
    assert not np.allclose(rotated(rosenbrock, rotation)(points), rosenbrock.function(points))
