"""Tabulated stages against the kernel they are made from, and the bounds that allow them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.experiments.staging.maps import largest, never_limited, stage_maps, weighted
from pipeline.experiments.staging.records import Currents, Weights
from pipeline.experiments.staging.stage_charges import Limits, charge, objective_of, scale_of, value_of
from pipeline.search.moves import Compiled
from tests.experiments.staging.staged import CALIBRATIONS, CURRENTS, LIMITS, grid, shipped, simple

EVEN = Weights(time=5.0, rise=5.0)
SLOW = {"resistance_ohm": 0.002, "time_constant_s": 90.0}
FAST = {"resistance_ohm": 0.001, "time_constant_s": 6.0}
BATTERIES = {name: shipped(name) for name in CALIBRATIONS} | {
    "no pair": simple(),
    "two pairs": simple(pairs={"slow": SLOW, "fast": FAST}, entropic_coefficient_v_k=-2e-4),
    "thermoneutral": shipped("lfp_8ah").model_copy(update={"thermoneutral_voltage_v": 3.31}),
}


@pytest.mark.parametrize("reading", ["positive", "final"])
@pytest.mark.parametrize("name", BATTERIES)
def test_the_compiled_objective_is_that_of_the_charges(name, reading):
    stages = grid(BATTERIES[name], slowest_a=8.0)
    limits = Limits(10.0, 90.0)
    objective = objective_of(stages, CURRENTS, EVEN, reading, limits)
    assert isinstance(objective, Compiled)
    corners = np.array([np.full(8, 8.0), np.full(8, 40.0), np.tile([8.0, 40.0], 4)])
    population = np.concatenate([corners, np.random.default_rng(3).uniform(8.0, 40.0, (500, 8))])
    scale = scale_of(stages, CURRENTS, reading)
    exact = value_of(charge(stages, population), scale, EVEN, reading, limits, 25.0)
    np.testing.assert_allclose(objective(population), exact, rtol=0.0, atol=1e-12)


def test_time_and_rise_are_exact_to_a_trillionth():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    population = np.random.default_rng(4).uniform(8.0, 40.0, (500, 8))
    found, maps = charge(stages, population), stage_maps(stages, CURRENTS)
    np.testing.assert_allclose(weighted(maps, 1.0, 0.0, 0.0, False)(population), found.time_s, rtol=1e-12)
    np.testing.assert_allclose(weighted(maps, 0.0, 1.0, 0.0, False)(population), found.end_k[:, -1], atol=1e-12)
    np.testing.assert_allclose(
        weighted(maps, 0.0, 1.0, 0.5, True)(population), 0.5 + found.rise_k("positive"), atol=1e-12
    )


def test_a_fast_pair_and_a_wide_range_get_more_spans():
    wide = Currents(low=1.0, high=40.0)
    stages = grid(BATTERIES["two pairs"], slowest_a=1.0)
    maps = stage_maps(stages, wide)
    assert maps.table.shape[1] > stage_maps(grid(shipped("lfp_8ah"), slowest_a=8.0), CURRENTS).table.shape[1]
    population = np.random.default_rng(5).uniform(1.0, 40.0, (500, 8))
    np.testing.assert_allclose(
        weighted(maps, 0.0, 1.0, 0.0, False)(population), charge(stages, population).end_k[:, -1], atol=1e-11
    )


def test_a_current_out_of_range_has_no_value():
    objective = objective_of(grid(shipped("lfp_8ah"), slowest_a=8.0), CURRENTS, EVEN, "positive", LIMITS)
    for beyond in (7.9, 40.1, np.nan, np.inf, -np.inf):
        population = np.full((2, 8), 20.0)
        population[0, 3] = beyond
        assert np.isnan(objective(population)).tolist() == [True, False]


def test_a_row_does_not_depend_on_its_neighbours():
    objective = objective_of(grid(shipped("lfp_8ah"), slowest_a=8.0), CURRENTS, EVEN, "positive", LIMITS)
    population = np.random.default_rng(5).uniform(8.0, 40.0, (25, 8))
    alone = [objective(row[None])[0] for row in population]
    np.testing.assert_array_equal(objective(population), alone)


# --- the bounds -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", BATTERIES)
@settings(max_examples=25, deadline=None)
@given(currents=st.lists(st.floats(8.0, 40.0), min_size=8, max_size=8))
def test_no_charge_exceeds_the_bounds(name, currents):
    stages = grid(BATTERIES[name], slowest_a=8.0)
    voltage_v, rise_k = largest(stages, CURRENTS)
    found = charge(stages, np.array([currents, np.full(8, 40.0)]))
    assert found.peak_v.max() < voltage_v
    assert np.abs(found.peak_k).max() < rise_k
    assert np.abs(found.end_k).max() < rise_k


def test_the_bounds_are_of_the_size_of_what_they_bound():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    voltage_v, rise_k = largest(stages, CURRENTS)
    hardest = charge(stages, np.full((1, 8), 40.0))
    assert voltage_v < hardest.peak_v.max() + 0.05
    assert rise_k < 2.0 * hardest.peak_k.max()


def test_where_a_limit_may_be_reached_every_charge_is_looked_at():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    assert never_limited(stages, CURRENTS, 3.65, 333.15)
    assert not never_limited(stages, CURRENTS, 3.5, 333.15)
    assert not never_limited(stages, CURRENTS, 3.65, 318.15)
    for reading, limits in (("positive", Limits(3.5, 60.0)), ("final", Limits(3.65, 45.0)), ("peak", LIMITS)):
        assert not isinstance(objective_of(stages, CURRENTS, EVEN, reading, limits), Compiled)
