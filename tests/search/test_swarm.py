from __future__ import annotations

import numpy as np
import pytest

from pipeline.record import Reference
from pipeline.search.algorithms import swarm
from pipeline.search.benchmark_functions import BENCHMARKS
from pipeline.search.box import Box
from pipeline.search.streams import STREAMS, generators

SPHERE = BENCHMARKS["sphere"].function


def test_a_step_is_the_equation_written_out(swarm_settings):
    settings, box = swarm_settings(), Box(np.array([-100.0]), np.array([100.0]))
    state = swarm.State(
        position=np.array([[[1.0], [4.0]]]),
        velocity=np.array([[[0.5], [-1.0]]]),
        own_position=np.array([[[2.0], [3.0]]]),
        own_value=np.array([[5.0, 9.0]]),
        best_position=np.array([[2.0]]),
        best_value=np.array([5.0]),
    )
    rand = np.array([[[[0.25], [0.5]], [[0.75], [0.125]]]])
    after = swarm.step(settings, swarm.Knobs(0.5, 2.0, 1.0), box, state, np.array([[7.0, 3.0]]), rand)
    # Particle 2 has just improved to 3 at 4, which is now its own and the common best; particle 1 has not.
    first = 0.5 * 0.5 + 2.0 * 0.25 * (2.0 - 1.0) + 1.0 * 0.75 * (4.0 - 1.0)
    second = 0.5 * -1.0 + 2.0 * 0.5 * 0.0 + 1.0 * 0.125 * 0.0
    np.testing.assert_allclose(after.velocity[0, :, 0], [first, second])
    np.testing.assert_allclose(after.position[0, :, 0], [1.0 + first, 4.0 + second])
    assert after.own_value.tolist() == [[5.0, 3.0]]
    assert after.best_position.tolist() == [[4.0]]
    assert after.best_value.tolist() == [3.0]


@pytest.mark.parametrize(("limit", "position", "velocity"), [("clamp", 10.0, 0.0), ("reflect", 7.0, -5.0)])
def test_walls(swarm_settings, limit, position, velocity):
    box, at = Box(np.array([0.0]), np.array([10.0])), np.array([[[8.0]]])
    state = swarm.State(at, np.array([[[50.0]]]), at, np.array([[1.0]]), at[:, 0], np.array([1.0]))
    settings = swarm_settings(position_limit=limit, velocity_limit=0.5)
    after = swarm.move(settings, swarm.Knobs(1.0, 0.0, 0.0), box, state, np.zeros((1, 2, 1, 1)))
    assert after.position.tolist() == [[[position]]], "5 is the largest velocity"
    assert after.velocity.tolist() == [[[velocity]]]


@pytest.mark.parametrize("limit", ["clamp", "reflect"])
def test_particles_stay_in_the_box_with_any_knobs(swarm_settings, limit):
    seen = []

    def record(x):
        seen.append(x)
        return SPHERE(x)

    settings = swarm_settings(position_limit=limit, velocity_limit=1.0, w=1.0, c1=2.0, c2=2.0, iterations=100)
    swarm.replicate(record, settings.box(), settings, 1)
    assert np.max(np.abs(np.concatenate(seen))) <= 5.0


@pytest.mark.parametrize("rand", STREAMS)
def test_same_seed_same_history_and_a_replicate_is_the_same_alone(swarm_settings, rand):
    settings = swarm_settings(rand=rand)
    first = swarm.replicate(SPHERE, settings.box(), settings, 11)
    again = swarm.replicate(SPHERE, settings.box(), settings, 11)
    other = swarm.replicate(SPHERE, settings.box(), settings, 12)
    for one, two in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, two)
    assert not np.array_equal(first.value, other.value)
    for number in range(5):
        rng = np.random.default_rng(np.random.SeedSequence([11, number]))
        alone = swarm.minimise(SPHERE, settings.box(), settings, rng)
        np.testing.assert_array_equal(alone.position[0], first.position[number])


def test_knobs_may_differ_between_replicates(swarm_settings):
    settings = swarm_settings()
    weights = np.array([0.25, 0.5, 0.75])
    random = generators(3, 0, 3)
    together = swarm.run(SPHERE, settings.box(), settings, swarm.Knobs(weights, 1.0, 1.0), random)
    for index, weight in enumerate(weights):
        knobs = swarm.Knobs(float(weight), 1.0, 1.0)
        alone = swarm.run(SPHERE, settings.box(), settings, knobs, generators(3, index, 1))
        np.testing.assert_allclose(alone.value[0], together.value[index], rtol=1e-14)


def test_history_counts_evaluations_and_never_rises(swarm_settings):
    calls = []

    def counted(x):
        calls.append(len(x))
        return SPHERE(x)

    settings = swarm_settings()
    history = swarm.replicate(counted, settings.box(), settings, 1)
    assert history.value.shape == (5, 21)
    assert history.evaluations[0].tolist() == [8 * (row + 1) for row in range(21)]
    assert sum(calls) == history.evaluations[:, -1].sum()
    assert np.all(np.diff(history.value, axis=1) <= 0.0)
    values = SPHERE(history.position.reshape(-1, 2)).reshape(history.value.shape)
    np.testing.assert_allclose(values, history.value, rtol=1e-12)


def test_a_reference_must_be_found_first(swarm_settings):
    settings = swarm_settings(w=Reference(source="tuning", value="w"))
    with pytest.raises(ValueError, match="w is w of tuning, which has not been found yet"):
        swarm.minimise(SPHERE, settings.box(), settings, np.random.default_rng(1))


def test_swarms_are_unstable_without_limits_where_theory_says_so(swarm_settings):
    # Order-2 stability with C1 = C2 (Poli, IEEE Trans. Evol. Comput. 13 (2009) 712): W = 1 grows, 0.75 and 1 does not.
    box = Box(np.array([-1e12]), np.array([1e12]))
    settings = swarm_settings(velocity_limit=1.0)
    at = np.random.default_rng(1).random((2000, 1, 1))
    for w, grows in ((1.0, True), (0.75, False)):
        state = swarm.State(at, at, 0.0 * at, np.zeros((2000, 1)), np.zeros((2000, 1)), np.zeros(2000))
        for rand in STREAMS["logistic"](generators(1, 0, 2000), (2, 1, 1), 60):
            state = swarm.move(settings, swarm.Knobs(w, 1.0, 1.0), box, state, rand)
        assert (np.var(state.position) > 1.0) == grows, w
