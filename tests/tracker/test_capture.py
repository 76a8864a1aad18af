"""Every tracker: steady light, ramps, dark, the limits of its duty; and what a caller may get wrong."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.errors import UserError
from pipeline.tracker.loop import KINDS, available, capture, course
from tests.tracker.conftest import HONEST, NAMES, tracker

STEADY = np.arange(0.0, 60.0, 0.1)


def test_every_yaml_is_another_kind():
    assert {tracker(name).kind for name in NAMES} == set(KINDS)


@pytest.mark.parametrize("name", NAMES)
def test_steady_light_at_1000_w_m2(source, name):
    share = capture(source, tracker(name), STEADY, 1000.0, 25.0) / available(source, 1000.0, 25.0)
    assert share[-200:].mean() >= 0.995
    assert share[-200:].max() <= 1.0 + 1e-9


@pytest.mark.parametrize("name", HONEST)
@pytest.mark.parametrize(("light", "cells"), [(1000.0, 60.0), (500.0, 10.0), (200.0, 40.0), (100.0, 25.0)])
def test_any_steady_light(source, name, light, cells):
    share = capture(source, tracker(name), STEADY, light, cells) / available(source, light, cells)
    assert share[-200:].mean() >= 0.99


def test_a_fixed_voltage_misses_where_cells_are_hot(source):
    share = capture(source, tracker("constant_voltage"), STEADY, 1000.0, 65.0) / available(source, 1000.0, 65.0)
    assert share[-1] < 0.9


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_captured_that_is_not_there(source, name):
    rng = np.random.default_rng(5)
    light = np.repeat(rng.uniform(0.0, 1100.0, 60), 20)
    got = capture(source, tracker(name), 0.1 * np.arange(light.size), light, 30.0)
    there = available(source, light, 30.0)
    # The input capacitor gives back in one row what it took in another.
    stored = 0.5 * source.boost.input_capacitance_f * 25.0**2 / 0.1
    assert np.all(got <= there + stored)
    assert got.sum() <= there.sum()


@pytest.mark.parametrize("name", HONEST)
def test_dawn_after_a_night(source, name):
    """In the dark nothing flows; light too faint to be measured leads no tracker astray for good."""
    light = np.concatenate([np.zeros(600), np.linspace(0.0, 800.0, 6000), np.full(600, 800.0)])
    got = capture(source, tracker(name), 0.1 * np.arange(light.size), light, 25.0)
    there = available(source, light, 25.0)
    assert np.all(got[:600] == 0.0)
    assert got[-300:].mean() / there[-1] > 0.99
    assert got.sum() / there.sum() > 0.98


@pytest.mark.parametrize("name", NAMES)
def test_the_duty_keeps_to_its_limits(source, name):
    found = course(source, tracker(name, least_duty=0.25, most_duty=0.28), STEADY, 1000.0, 25.0)
    assert np.all((found.duty >= 0.25) & (found.duty <= 0.28))
    assert found.duty[-1] > 0.27  # more would be better


def test_perturb_and_observe_swings_by_three_steps(source):
    found = course(source, tracker("perturb_observe"), STEADY, 1000.0, 25.0)
    levels = np.unique(np.round(found.duty[-200:], 9))
    assert 3 <= len(levels) <= 4
    np.testing.assert_allclose(np.diff(levels), 0.005, rtol=1e-6)


def test_incremental_conductance_comes_to_rest(source):
    found = course(source, tracker("incremental_conductance"), STEADY, 1000.0, 25.0)
    assert np.ptp(found.duty[-200:]) == 0.0


def test_steps_grow_with_the_distance(source):
    found = course(source, tracker("variable_step", start_voltage_share=0.95), STEADY, 1000.0, 25.0)
    moves = np.abs(np.diff(found.duty))
    assert moves[:5].max() == pytest.approx(0.03)
    assert moves[-100:].max() < 0.002


def test_a_shorter_period_follows_faster_ramps(source):
    light = np.concatenate([np.full(1200, 100.0), np.linspace(100.0, 1000.0, 180), np.full(400, 1000.0)])
    time = 0.05 * np.arange(light.size)
    there = available(source, light, 25.0).sum()
    slow, fast = (
        capture(source, tracker("perturb_observe", perturbation_period_s=period), time, light, 25.0).sum() / there
        for period in (0.1, 0.02)
    )
    assert fast > slow + 0.01


def test_the_same_weather_gives_the_same_twice(source):
    swarm = tracker("particle_swarm")
    first, second = (capture(source, swarm, STEADY, 700.0, 25.0) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    other = tracker("particle_swarm", chaos_start=0.6)
    assert np.any(capture(source, other, STEADY, 700.0, 25.0) != first)


def test_more_panels_scale_with_a_converter_made_for_them(source):
    twice = source._replace(
        panel=source.panel.model_copy(update={"panels_in_parallel": 2}),
        boost=source.boost.model_copy(
            update={
                "inductance_h": source.boost.inductance_h / 2,
                "input_capacitance_f": source.boost.input_capacitance_f * 2,
                "inductor_resistance_ohm": source.boost.inductor_resistance_ohm / 2,
                "on_resistance_ohm": source.boost.on_resistance_ohm / 2,
                "rectifier_resistance_ohm": source.boost.rectifier_resistance_ohm / 2,
            }
        ),
    )
    one, two = (capture(of, tracker("perturb_observe"), STEADY, 900.0, 25.0) for of in (source, twice))
    np.testing.assert_allclose(two, 2 * one, rtol=1e-9)


@pytest.mark.parametrize(
    ("time", "light", "message"),
    [
        ([0.0, 1.0, 1.0], 500.0, "time_s: row 2 is 1 s after 1 s"),
        ([0.0, 1.0, 0.5], 500.0, "row 2 is 0.5 s"),
        ([0.0, 1.0, 2.0], [1.0, -2.0, 3.0], "irradiance_w_m2: value -2"),
        ([0.0, 1.0, 2.0], [1.0, np.nan, 3.0], "irradiance_w_m2"),
        ([0.0, np.nan, 2.0], 500.0, "time_s: row 1"),
        ([], 500.0, "time_s: no rows"),
    ],
)
def test_weather_that_cannot_be_is_refused(source, time, light, message):
    with pytest.raises(UserError, match=message):
        capture(source, tracker("perturb_observe"), time, light, 25.0)
