"""Closed forms: what a charge must be where it can be written down."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from tests.charge.samples import charge, settings, values

PLAIN = {
    "name": "plain",
    "title": "Plain",
    "cells_in_series": 2,
    "capacity_ah": 1.0,
    "open_circuit_voltage_v": {"polynomial": [2.0, -0.5]},
    "series_resistance_ohm": 0.05,
    "thermal": {"heat_capacity_j_k": 100.0, "resistance_k_w": 1e12},
}


def constant(current_a, seconds, **more):
    phases = {"charge": {"constant_current": {"current_a": current_a}}}
    return Mode(title="Constant", phases=phases, stop={"elapsed_s": seconds} | more)


def test_charge_counts_coulombs():
    found = values(charge(Battery(**PLAIN), constant(0.5, 1800), settings(0.1)))
    assert found["end_soc"] == pytest.approx(0.1 + 0.25, rel=1e-13)
    assert found["charge_in_ah"] == pytest.approx(0.25, rel=1e-13)
    assert found["charge_efficiency"] == pytest.approx(1.0, rel=1e-13)


def test_a_resistor_warms_an_insulated_battery():
    found = values(charge(Battery(**PLAIN), constant(2.0, 600), settings(0.1)))
    assert found["peak_temperature_rise_k"] == pytest.approx(2 * 0.05 * 4.0 * 600 / 100.0, rel=1e-9)


def test_a_cooled_battery_approaches_its_final_temperature():
    cooled = PLAIN | {"thermal": {"heat_capacity_j_k": 100.0, "resistance_k_w": 3.0}}
    trace = charge(Battery(**cooled), constant(2.0, 900), settings(0.1)).trace
    expected = 25.0 + 0.4 * 3.0 * -np.expm1(-trace["Test Time / s"] / 300.0)
    assert trace["Surface Temperature / degC"] == pytest.approx(expected, abs=1e-9)


def test_a_pair_answers_a_step_by_the_exponential():
    paired = PLAIN | {"pairs": {"only": {"resistance_ohm": 0.1, "time_constant_s": 7.0}}}
    window = {"start_s": 0.0, "length_s": 40.0}
    wave = charge(Battery(**paired), constant(0.5, 40), settings(0.1, windows=[window])).waveform
    time, voltage = wave["time_s"], wave["voltage_v"]
    cell = 2.0 - 0.5 * (0.9 - 0.5 * time / 3600) + 0.05 * 0.5 + 0.1 * 0.5 * -np.expm1(-time / 7.0)
    assert len(time) > 200
    assert voltage == pytest.approx(2 * cell, abs=1e-12)


def test_held_voltage_lets_the_current_fall_by_the_exponential():
    mode = Mode(
        title="Held",
        phases={"charge": {"constant_voltage": {"voltage_v": 3.6, "max_current_a": 100.0}}},
        stop={"elapsed_s": 600},
    )
    found = values(charge(Battery(**PLAIN), mode, settings(0.1)))
    # x' = -(1.8 - 2 + x / 2) / (0.05 * 3600)
    x = 0.4 + (0.9 - 0.4) * np.exp(-600 * 0.5 / (0.05 * 3600))
    assert found["end_soc"] == pytest.approx(1 - x, abs=1e-9)
    assert found["time_at_voltage_limit_s"] == 600


def test_a_supply_of_constant_power_is_drawn_in_full():
    from pipeline.charge.simulate import Supply

    supply = Supply(np.array([0.0, 100.0, 200.0]), np.array([3.0, 0.0, 1e9]))
    result = charge(Battery(**PLAIN), constant(2.0, 300), settings(0.1, sample_interval_s=100), supply)
    found = values(result)
    assert found["time_at_supply_limit_s"] == pytest.approx(200.0, abs=1e-9)
    assert result.trace["Charging Energy / Wh"][0] == pytest.approx(3.0 * 100 / 3600, rel=1e-12)
    assert result.trace["Current / A"][1] == pytest.approx(0.0, abs=1e-14)
    assert result.trace["Current / A"][2] == pytest.approx(2.0, rel=1e-12)
    assert list(result.trace["supply_limited_share"]) == pytest.approx([1, 1, 0], abs=1e-9)
