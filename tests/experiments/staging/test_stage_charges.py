"""Staged charges of a whole population: exact solutions, an independent integration, the engine itself."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from pipeline.cell.circuit import compile_cell
from pipeline.cell.curves import value_and_slope
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate
from pipeline.experiments.staging.records import READINGS, Weights
from pipeline.experiments.staging.stage_charges import Limits, charge, fitness, objective_of, scale_of, value_of
from tests.experiments.staging.staged import CALIBRATIONS, CURRENTS, EDGES, LIMITS, PRINTED, grid, shipped, simple

EVEN = Weights(time=5.0, rise=5.0)


# --- exact -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("name", "seconds"), [("lfp_8ah", 1553.26), ("lfp_8ah_measured", 1533.84)])
def test_the_printed_currents_take_exactly_this_long(name, seconds):
    battery = shipped(name)
    found = charge(grid(battery), PRINTED[None, :])
    exact = 0.1 * 3600.0 * battery.capacity_ah / PRINTED
    np.testing.assert_allclose(found.stage_s[0], exact, rtol=1e-13)
    assert found.time_s[0] == pytest.approx(seconds, abs=0.005)


def test_without_cooling_heat_is_resistance_times_current_times_charge():
    found = charge(grid(simple()), PRINTED[None, :])
    rise = np.cumsum(0.005 * PRINTED * 2880.0) / 270.0
    np.testing.assert_allclose(found.end_k[0], rise, rtol=1e-12)
    np.testing.assert_allclose(found.peak_k[0], rise, rtol=1e-12)
    np.testing.assert_allclose(found.end_v[0], 3.2 + 0.005 * PRINTED, rtol=1e-14)


def test_at_constant_current_a_cooled_cell_follows_one_exponential():
    found = charge(grid(simple(thermal={"heat_capacity_j_k": 270.0, "resistance_k_w": 4.0})), np.full((1, 8), 20.0))
    time = np.cumsum(found.stage_s[0])
    np.testing.assert_allclose(found.end_k[0], 4.0 * 0.005 * 400.0 * -np.expm1(-time / 1080.0), rtol=1e-12)


def test_a_pair_of_constant_resistance_charges_exponentially_and_heats_by_its_square():
    pair = {"one": {"resistance_ohm": 0.002, "time_constant_s": 30.0}}
    found = charge(grid(simple(pairs=pair, series_resistance_ohm=0.0)), np.full((1, 8), 20.0))
    time = np.cumsum(found.stage_s[0])
    voltage = 0.04 * -np.expm1(-time / 30.0)
    np.testing.assert_allclose(found.end_v[0], 3.2 + voltage, rtol=1e-13)
    # int v^2 / R dt, and nothing else: the capacitor's share is stored, not heat.
    heat = 0.04**2 / 0.002 * (time + 60.0 * np.expm1(-time / 30.0) - 15.0 * np.expm1(-time / 15.0))
    np.testing.assert_allclose(found.end_k[0], heat / 270.0, rtol=1e-11)


def test_entropy_alone_warms_as_its_exponential():
    found = charge(grid(simple(series_resistance_ohm=0.0, entropic_coefficient_v_k=1e-4)), PRINTED[None, :])
    charged = 2880.0 * np.arange(1, 9)
    np.testing.assert_allclose(found.end_k[0], 298.15 * np.expm1(1e-4 * charged / 270.0), rtol=1e-11)


# --- independent ----------------------------------------------------------------------------------------------------
def integrated(battery, currents, edges=EDGES):
    """Return the rise at the end of each stage by DOP853, from knot to knot of the curves."""
    cell = compile_cell(battery)
    knots = sorted({*edges, *(s for s in np.arange(1, 40) / 40 if edges[0] < s < edges[-1])})
    v, t, ends = 0.0, 298.15, []
    for low, high in pairwise(knots):
        current = currents[np.searchsorted(edges, 0.5 * (low + high)) - 1]

        def slopes(time, y, current=current, low=low):
            x = 1.0 - low - time * current / float(cell["charge_as"])
            r0, _ = value_and_slope(cell, 2, x)
            dudt, _ = value_and_slope(cell, 1, x)
            r1, r1_by_x = value_and_slope(cell, 4, x)
            tau = float(cell["tau_s"][0])
            # C = tau / R1; dC/dt = -tau / R1^2 dR1/dx dx/dt.
            dc_dt = tau / r1**2 * r1_by_x * current / float(cell["charge_as"])
            heat = current**2 * r0 + y[0] ** 2 * (1.0 / r1 - 0.5 * dc_dt) + current * y[1] * dudt
            cooled = (y[1] - 298.15) / float(cell["thermal_resistance_k_w"])
            return [(r1 * current - y[0]) / tau, (heat - cooled) / float(cell["heat_capacity_j_k"])]

        span = (high - low) * float(cell["charge_as"]) / current
        found = solve_ivp(slopes, (0.0, span), [v, t], method="DOP853", rtol=1e-12, atol=1e-12)
        v, t = found.y[:, -1]
        if any(abs(high - edge) < 1e-9 for edge in edges):
            ends.append(t - 298.15)
    return np.array(ends)


@pytest.mark.parametrize("name", ["lfp_8ah", "lfp_8ah_half_entropy"])
def test_agrees_with_an_independent_integration(name):
    found = charge(grid(shipped(name)), PRINTED[None, :])
    np.testing.assert_allclose(found.end_k[0], integrated(shipped(name), PRINTED), atol=2e-10)


# --- the engine itself ------------------------------------------------------------------------------------------------
def simulated(battery, currents, edges=EDGES, limit_v=4.5, **engine):
    phase = {
        "staged": {"currents_a": list(map(float, currents)), "soc_edges": list(edges[1:])},
        "limit": {"voltage_v": limit_v},
    }
    mode = Mode.model_validate({"title": "staged", "phases": {"stages": phase}, "stop": {"elapsed_s": 20000.0}})
    conditions = ChargeSettings(initial_soc=edges[0], ambient_c=25.0, sample_interval_s=5.0)
    made = simulate(battery, mode, BENCH, conditions, EngineSettings(tolerance=1e-10, **engine))
    return made, {row.quantity: row.value for row in made.summary}


CASES = [
    *((name, EDGES, PRINTED) for name in (*CALIBRATIONS, "lfp_8ah_measured")),
    ("lfp_8ah", EDGES, np.array([8.0, 40.0, 9.1, 38.3, 12.7, 25.0, 40.0, 8.0])),
    ("lfp_8ah", (0.1, 0.9), np.array([17.3])),
    ("lfp_8ah", (0.12, 0.37, 0.52, 0.881), np.array([33.0, 11.0, 21.0])),
    ("lfp_8ah", tuple(np.linspace(0.05, 0.95, 17).tolist()), np.linspace(38.0, 6.0, 16)),
]


@pytest.mark.parametrize(("name", "edges", "currents"), CASES)
def test_equals_simulate(name, edges, currents):
    made, summary = simulated(shipped(name), currents, edges)
    found = charge(grid(shipped(name), edges), currents[None, :])
    assert found.time_s[0] == pytest.approx(summary["end_time_s"], rel=1e-9)
    # The engine iterates node temperatures to 1e-6 K, which leaves some 1e-9 K at the end of a charge.
    ends = np.array(made.phases["end_temperature_c"]) - 25.0
    np.testing.assert_allclose(found.end_k[0], ends, rtol=1e-9, atol=4e-9)
    assert found.peak_v.max() == pytest.approx(np.max(made.trace["voltage_max_v"]), rel=1e-9)
    # The engine looks at its nodes alone, so a maximum between two of them escapes it.
    peak = summary["peak_temperature_rise_k"]
    assert -1e-8 <= found.rise_k("peak")[0] - peak < 1e-4


def test_a_peak_within_a_stage_is_found_between_the_engines_nodes():
    currents = np.array([8.0, 40.0, 9.1, 38.3, 12.7, 25.0, 40.0, 8.0])
    found = charge(grid(shipped("lfp_8ah")), currents[None, :])
    ends = np.append(0.0, found.end_k[0])
    assert found.peak_k[0, 7] > max(ends[7], ends[8]) + 1e-3
    _, summary = simulated(shipped("lfp_8ah"), currents, maximum_step_s=0.05)
    assert found.rise_k("peak")[0] == pytest.approx(summary["peak_temperature_rise_k"], abs=2e-8)


def test_scaled_cells_in_series_equal_simulate_too():
    battery = shipped("lfp_8ah").model_copy(update={"cells_in_series": 4, "scaled_to_capacity_ah": 16.0})
    made, summary = simulated(battery, 2 * PRINTED, limit_v=20.0)
    found = charge(grid(battery), 2 * PRINTED[None, :])
    np.testing.assert_allclose(found.end_k[0], np.array(made.phases["end_temperature_c"]) - 25.0, rtol=1e-9, atol=4e-9)
    assert found.peak_v.max() == pytest.approx(np.max(made.trace["voltage_max_v"]), rel=1e-9)
    assert found.time_s[0] == pytest.approx(summary["end_time_s"], rel=1e-9)


def test_a_measured_thermoneutral_voltage_equals_simulate_too():
    battery = shipped("lfp_8ah").model_copy(update={"thermoneutral_voltage_v": 3.31})
    made, _ = simulated(battery, PRINTED)
    found = charge(grid(battery), PRINTED[None, :])
    np.testing.assert_allclose(found.end_k[0], np.array(made.phases["end_temperature_c"]) - 25.0, rtol=1e-9, atol=4e-9)


# --- a population ----------------------------------------------------------------------------------------------------
def test_a_population_at_once_equals_one_by_one():
    population = np.random.default_rng(5).uniform(8.0, 40.0, (25, 8))
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    together = charge(stages, population)
    for row, currents in enumerate(population):
        alone = charge(stages, currents[None, :])
        for one, all_of_them in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one[0], all_of_them[row])


def test_the_grid_is_fine_enough_wherever_it_is_asked_for():
    battery = shipped("lfp_8ah")
    slow = np.full((1, 8), 2.0)
    coarse, fine = (charge(grid(battery, slowest_a=least), slow).end_k for least in (2.0, 0.25))
    np.testing.assert_allclose(coarse, fine, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(8.0, 40.0), min_size=8, max_size=8))
def test_fitness_lies_between_0_and_2_and_readings_in_order(currents):
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    found = charge(stages, np.array([currents]))
    final, positive, peak = (float(found.rise_k(reading)[0]) for reading in READINGS)
    assert final <= positive + 1e-12
    assert final <= peak + 1e-12
    assert peak >= 0.0
    for reading in READINGS:
        value = objective_of(stages, CURRENTS, EVEN, reading, LIMITS)(np.array([currents]))
        assert -1e-12 <= value[0] <= 1.0 + 1e-12
        assert 0.0 <= fitness(value)[0] <= 2.0


def test_the_ends_of_the_scale_have_fitness_as_the_paper_says():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    time_alone, rise_alone = Weights(time=1.0, rise=1e-9), Weights(time=1e-9, rise=1.0)
    corners = np.array([np.full(8, 40.0), np.full(8, 8.0)])
    for reading in READINGS:
        fast, slow = fitness(objective_of(stages, CURRENTS, time_alone, reading, LIMITS)(corners))
        assert (fast, slow) == (pytest.approx(2.0), pytest.approx(0.0, abs=1e-6))
        hot, cool = fitness(objective_of(stages, CURRENTS, rise_alone, reading, LIMITS)(corners))
        assert hot == pytest.approx(0.0, abs=1e-6)
        assert cool > 1.5


def test_what_exceeds_a_limit_is_worse_than_all_that_does_not():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    population = np.array([PRINTED, np.full(8, 40.0), np.full(8, 30.0)])
    for limits in (Limits(3.43, 60.0), Limits(3.65, 28.0)):
        values = objective_of(stages, CURRENTS, EVEN, "peak", limits)(population)
        assert np.all(values > 1.0)
        # The farther beyond the limit, the worse: a search finds its way back.
        assert values[1] > values[2]
        np.testing.assert_array_equal(fitness(values), 0.0)
    assert np.all(objective_of(stages, CURRENTS, EVEN, "peak", LIMITS)(population) <= 1.0)


def test_the_weights_count_by_their_ratio():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    found, scale = charge(stages, PRINTED[None, :]), scale_of(stages, CURRENTS, "final")
    values = [
        value_of(found, scale, Weights(time=alpha, rise=beta), "final", LIMITS, 25.0)[0]
        for alpha, beta in ((5.0, 5.0), (0.5, 0.5), (7.0, 3.0))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-14)
    assert values[2] != values[0]
    time = (found.time_s[0] - 576.0) / (2880.0 - 576.0)
    rise = found.end_k[0, -1] / scale.hottest_k
    assert values[2] == pytest.approx(0.7 * time + 0.3 * rise, rel=1e-13)


# --- bad input -------------------------------------------------------------------------------------------------------
def test_currents_that_the_grid_is_not_made_for_are_refused():
    stages = grid(shipped("lfp_8ah"), slowest_a=8.0)
    with pytest.raises(ValueError, match=r"current of 7 A; the grid is made for 8 A"):
        charge(stages, np.full((1, 8), 7.0))
    with pytest.raises(ValueError, match=r"current of nan A"):
        charge(stages, np.full((1, 8), math.nan))
    with pytest.raises(ValueError, match=r"allowed is \(n, 8\)"):
        charge(stages, np.full((1, 7), 10.0))
    assert charge(stages, np.empty((0, 8))).time_s.shape == (0,)


@pytest.mark.parametrize("edges", [(0.1,), (0.1, 0.1, 0.2), (0.5, 0.3), (0.2, 1.0), (-0.1, 0.5)])
def test_edges_that_do_not_rise_are_refused(edges):
    with pytest.raises(ValueError, match="must rise from 0 or more to less than 1"):
        grid(shipped("lfp_8ah"), edges)


def test_batteries_with_other_parts_are_refused():
    side = {"current_a": 1e-3, "reference_voltage_v": 3.3, "voltage_scale_v": 0.1}
    with pytest.raises(ValueError, match="battery has side_reaction"):
        grid(simple(side_reaction=side))
    with pytest.raises(ValueError, match="battery has acceptance"):
        grid(simple(acceptance={"resistance_ohm": 0.01, "time_constant_s": 30.0}))
    shaped = {"one": {"resistance_ohm": {"factor": 0.01, "soc_offset": 0.1}, "time_constant_s": 30.0}}
    with pytest.raises(ValueError, match=r"pairs\.one\.resistance_ohm must be a number, a polynomial or a table"):
        grid(simple(pairs=shaped))
