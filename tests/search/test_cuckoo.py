"""Cuckoo search against the authors' equations written out nest by nest, and the invariants of its variants."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.stats import chisquare, ks_2samp

from pipeline.search import moves, nests
from pipeline.search.algorithms import cuckoo
from pipeline.search.benchmark_functions import BENCHMARKS, problem
from pipeline.search.box import Box
from pipeline.search.registry import replicated, replicated_alike
from pipeline.search.streams import generators

RASTRIGIN = BENCHMARKS["rastrigin"].function
VARIANTS = {
    "plain": {},
    "inertia": {"inertia": 0.9, "inertia_end": 0.4},
    "integral": {"ki": 0.05},
    "both": {"ki": 0.05, "leak": 0.8, "inertia": 0.7},
}


def settings(low=-5.0, high=5.0, dimensions=3, **changes):
    values = {"title": "cuckoo", "nests": 7, "generations": 40, "replicates": 4}
    variables = {f"x{number}": {"low": low, "high": high} for number in range(dimensions)}
    return cuckoo.Settings(**{**values, "variables": variables, **changes})


def plain_cuckoo_search(objective, box, chosen, rng):
    """Return the best value after each generation: Yang and Deb's search, nothing added, on the same random numbers."""
    nest = box.low + rng.random((chosen.nests, len(box.low))) * (box.high - box.low)
    value = objective(nest)
    course = [value.min()]
    drawn = moves.draws(chosen.nests, len(box.low), chosen.levy_exponent, [rng])
    blocks = (zip(*(part[0] for part in block), strict=True) for block in drawn)
    numbers = itertools.chain.from_iterable(blocks)
    for _, (step, (one, other), length, chance) in zip(range(chosen.generations), numbers, strict=False):
        best = nest[np.argmin(value)].copy()
        flown = np.clip(nest + chosen.step_scale * step * (nest - best), box.low, box.high)
        found = objective(flown)
        nest, value = np.where((found <= value)[:, None], flown, nest), np.minimum(found, value)
        difference = np.where(chance < chosen.pa, length[:, None] * (nest[one] - nest[other]), 0.0)
        walked = np.clip(nest + difference, box.low, box.high)
        found = objective(walked)
        nest, value = np.where((found <= value)[:, None], walked, nest), np.minimum(found, value)
        course.append(value.min())
    return np.array(course)


@pytest.mark.parametrize("leak", [0.0, 0.9, 1.0])
def test_without_inertia_and_integral_it_is_plain_cuckoo_search_bit_for_bit(leak):
    chosen = settings(ki=0.0, inertia=1.0, inertia_end=1.0, leak=leak, generations=70)
    box = chosen.box()
    history = cuckoo.minimise(RASTRIGIN, box, chosen, np.random.default_rng(3))
    expected = plain_cuckoo_search(RASTRIGIN, box, chosen, np.random.default_rng(3))
    np.testing.assert_array_equal(history.value[0], expected)


def test_the_integral_and_the_inertia_change_the_search():
    values = [replicated(RASTRIGIN, settings(**changes), 1).value for changes in VARIANTS.values()]
    assert all(not np.array_equal(one, other) for one, other in itertools.combinations(values, 2))


def law(width=100.0, dimensions=2, **changes):
    edge = np.full(dimensions, width)
    return moves.Law(**{"pa": 0.25, "step_scale": 0.01, "ki": 0.05, "leak": 0.9, "low": -edge, "high": edge} | changes)


def test_a_flight_is_the_reconstructed_equation():
    position = np.array([[1.0, -2.0], [3.0, 0.5], [2.0, 1.0]])
    before, levy_numbers = np.array([[0.5, 0.0], [-1.0, 2.0], [0.0, 1.0]]), np.array([[2.0, -1], [0, 10], [5, 5]])
    summed, flown = before.copy(), np.empty((3, 2))
    moves.fly(position, 2, summed, levy_numbers, 0.8, law(), flown)
    error = position[2] - position
    np.testing.assert_allclose(summed, 0.9 * before + error)
    np.testing.assert_allclose(flown, 0.8 * position - 0.01 * levy_numbers * error + 0.05 * (0.9 * before + error))


def test_a_walk_moves_the_coordinates_that_are_found():
    position, walked = np.array([[0.0, 0.0], [1.0, 2.0], [5.0, -4.0]]), np.empty((3, 2))
    partners = np.array([[1, 2, 0], [2, 0, 1]])
    chance = np.array([[0.1, 0.9], [0.9, 0.9], [0.2, 0.1]])
    moves.walk(position, partners, np.array([0.5, 1.0, 0.25]), chance, law(), walked)
    np.testing.assert_allclose(walked, [[0.5 * (1 - 5), 0.0], [1.0, 2.0], [5 + 0.25 * (0 - 1), -4 + 0.25 * (0 - 2)]])


def test_only_what_is_no_worse_is_kept():
    position, value = np.array([[0.0], [1.0], [2.0]]), np.array([1.0, 2.0, np.inf])
    leader = moves.keep(position, value, position + 10.0, np.array([1.0, 3.0, np.nan]))
    assert position[:, 0].tolist() == [10.0, 1.0, 2.0]
    assert value.tolist() == [1.0, 2.0, np.inf], "what is not a number is never kept"
    assert leader == 0


@pytest.mark.parametrize("placement", ["centred", "shifted", "rotated"])
@pytest.mark.parametrize("changes", VARIANTS.values(), ids=VARIANTS)
def test_a_compiled_objective_takes_the_course_of_any_other_bit_for_bit(changes, placement):
    for name in ("ackley", "rosenbrock"):
        objective, chosen = problem(name, placement, 3, 0.4, 1).objective, settings(**changes, generations=70)
        compiled, called = replicated(objective, chosen, 7), replicated(objective.__call__, chosen, 7)
        for one, other in zip(compiled, called, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("name", "invariant"), [("plain", True), ("integral", True), ("inertia", False), ("both", False)]
)
def test_translation(name, invariant):
    """A search that favours no place takes the same course when box and function are moved together."""
    offset = 3.0
    chosen, moved = settings(**VARIANTS[name]), settings(-5.0 + offset, 5.0 + offset, **VARIANTS[name])
    here = replicated(RASTRIGIN, chosen, 2)
    there = replicated(lambda x: RASTRIGIN(x - offset), moved, 2)
    same = np.abs(there.position - offset - here.position).max(axis=(0, 2))
    assert (same.max() < 1e-9) == invariant
    if not invariant:
        assert same[1:].max() > 0.1


def test_inertia_alone_walks_to_the_origin_whatever_it_searches():
    flat = replicated(lambda x: np.zeros(len(x)), settings(**VARIANTS["inertia"], generations=200), 1)
    assert np.abs(flat.position[:, -1]).max() < 1e-6
    fair = replicated(lambda x: np.zeros(len(x)), settings(generations=200), 1)
    assert np.abs(fair.position[:, -1]).max() > 0.1


@pytest.mark.parametrize("changes", VARIANTS.values(), ids=VARIANTS)
def test_same_seed_same_history_and_a_replicate_is_the_same_alone(changes):
    chosen = settings(**changes)
    together = replicated(RASTRIGIN, chosen, 11)
    for one, two in zip(together, replicated(RASTRIGIN, chosen, 11), strict=True):
        np.testing.assert_array_equal(one, two)
    assert not np.array_equal(together.value, replicated(RASTRIGIN, chosen, 12).value)
    for number, rng in enumerate(generators(11, 0, 4)):
        alone = cuckoo.minimise(RASTRIGIN, chosen.box(), chosen, rng)
        np.testing.assert_array_equal(alone.position[0], together.position[number])


def test_searches_side_by_side_are_what_they_are_alone():
    sphere = BENCHMARKS["sphere"].function
    tasks = [(one, settings().box(), settings(**VARIANTS[name])) for name in VARIANTS for one in (RASTRIGIN, sphere)]
    for (objective, _, chosen), found in zip(tasks, replicated_alike(tasks, 5), strict=True):
        np.testing.assert_array_equal(found.position, replicated(objective, chosen, 5).position)
    with pytest.raises(ValueError, match="same nests, generations, levy_exponent and dimensions"):
        replicated_alike([*tasks, (sphere, settings().box(), settings(nests=9))], 5)


def test_a_longer_search_begins_like_a_shorter_one():
    short, long = (replicated(RASTRIGIN, settings(generations=count), 1) for count in (20, 50))
    np.testing.assert_array_equal(long.position[:, :21], short.position)


@pytest.mark.parametrize("changes", [*VARIANTS.values(), {"ki": 5.0, "leak": 1.0}, {"step_scale": 100.0}], ids=str)
def test_the_box_is_never_left_and_every_evaluation_counts(changes):
    seen = []

    def record(x):
        seen.append(x.copy())
        return RASTRIGIN(x)

    history = replicated(record, settings(low=-2.0, high=5.0, **changes), 1)
    positions = np.concatenate(seen)
    assert positions.min() >= -2.0
    assert positions.max() <= 5.0
    assert len(positions) == history.evaluations[:, -1].sum() == 4 * 7 * (1 + 2 * 40)
    np.testing.assert_array_equal(RASTRIGIN(history.best_position()), history.best_value())


def test_the_levy_numbers_have_the_tail_of_their_law():
    # Mantegna's u / |v|^(1/1.5) falls off as the power 1.5; the normal factor changes the scale alone.
    assert moves.mantegna_deviation(1.5) == pytest.approx(0.6966, abs=5e-5)
    drawn = moves.draws(50, 50, 1.5, generators(1, 0, 10))
    size = np.sort(np.abs(np.concatenate([next(drawn).levy.ravel() for _ in range(2)])))
    upper = size[-len(size) // 1000 :]
    assert 1.0 / np.mean(np.log(upper / upper[0])) == pytest.approx(1.5, abs=0.1), "Hill's estimate of the exponent"


@pytest.mark.parametrize("exponent", [1.2, 1.5, 1.9])
def test_the_levy_numbers_are_those_of_three_normal_numbers(exponent):
    rng = np.random.default_rng(3)
    u, v, normal = rng.standard_normal((3, 200_000))
    direct = moves.mantegna_deviation(exponent) * u / np.abs(v) ** (1 / exponent) * normal
    found = moves.levy_numbers(rng.random((4, 200_000)), exponent)
    assert ks_2samp(found, direct).pvalue > 0.01
    assert np.all(np.isfinite(moves.levy_numbers(np.full((4, 1, 1), 0.0), exponent)))
    middle = np.array([0.0, 0.0, 0.5, 0.5]).reshape(4, 1, 1)
    assert np.all(np.isfinite(moves.levy_numbers(middle, exponent))), "nothing over nothing"


def test_every_order_of_the_partners_is_as_likely():
    orders = moves.permutations(np.random.default_rng(5).random((60_000, 4)))
    counts = np.unique(orders, axis=0, return_counts=True)[1]
    assert len(counts) == 24
    assert chisquare(counts).pvalue > 0.01


def test_partners_are_permutations_and_numbers_uniform():
    drawn = next(moves.draws(9, 2, 1.5, generators(1, 0, 3)))
    expected = np.broadcast_to(np.arange(9), (3, moves.BLOCK, 2, 9))
    np.testing.assert_array_equal(np.sort(drawn.partners, axis=-1), expected)
    assert 0.0 <= drawn.length.min() <= drawn.length.max() < 1.0
    assert 0.45 < drawn.chance.mean() < 0.55


def test_inertia_falls_evenly():
    np.testing.assert_allclose(
        settings(inertia=0.9, inertia_end=0.5, generations=5).weights(), [0.9, 0.8, 0.7, 0.6, 0.5]
    )
    assert set(settings(inertia=0.7).weights()) == {0.7}
    with pytest.raises(ValidationError, match="inertia_end"):
        settings(inertia_end=1.5)


def test_a_box_away_from_the_origin_is_filled_evenly():
    box = Box(np.array([10.0, 20.0]), np.array([11.0, 40.0]))
    search = nests.Search(lambda x: x[:, 0], box, settings(), np.random.default_rng(1).random((5, 2000, 2)))
    np.testing.assert_allclose(search.nests.position.mean(axis=(0, 1)), [10.5, 30.0], rtol=0.01)
    np.testing.assert_array_equal(search.course.value[:, 0], search.nests.position[:, :, 0].min(axis=1))
