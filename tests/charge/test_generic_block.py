"""The generic lead-acid block: its parameters, its voltage, and where its charges end."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.records import EngineSettings, Mode
from pipeline.errors import UserError
from tests.charge import generic_block as block
from tests.charge.samples import battery, charge, load, settings, values
from tests.charge.test_exact import constant

TIGHT = EngineSettings(tolerance=1e-11)
GENERIC = battery("lead_acid_generic")


def reflex(frequency_hz, **more):
    knobs = {"charge_a": 2.1, "charge_share": 0.9, "discharge_a": 0.5, "discharge_share": 0.05}
    return Mode(title="Reflex", frequency_hz=frequency_hz, phases={"all": {"reflex": {}}}, stop=more, **knobs)


def test_the_values_are_those_of_the_equations():
    assert GENERIC.open_circuit_voltage_v.full_v == block.E0
    assert GENERIC.open_circuit_voltage_v.polarisation_v == pytest.approx(block.K * block.Q, rel=1e-12)
    pair = GENERIC.pairs["polarisation"]
    assert (pair.resistance_ohm.factor, pair.resistance_ohm.depth_offset) == (block.K, 0.1)
    assert (pair.time_constant_s, GENERIC.series_resistance_ohm, GENERIC.capacity_ah) == (block.TAU, block.R, block.Q)


def test_the_values_follow_from_three_points_of_the_discharge_curve():
    """Full, end of the exponential zone and nominal, at 1.4 A: voltages printed to a tenth of a millivolt."""
    q, current, points = block.Q, 1.4, ((0.0, 13.0658), (0.0233333, 12.2171), (2.17222, 12.0))
    rows, right = [[1.0, 0.0, 1.0]], [points[0][1] + block.R * current]
    for extracted, voltage in points[1:]:
        rows.append([1.0, -q / (q - extracted) * (extracted + current), np.exp(-3 / 0.0233333 * extracted)])
        right.append(voltage + block.R * current)
    e0, k, a = np.linalg.solve(rows, right)
    assert (e0, a) == pytest.approx((block.E0, block.A), abs=2e-4)
    assert k == pytest.approx(block.K, rel=1e-3)


@pytest.mark.parametrize(("soc", "current"), [(0.2, 2.1), (0.9, 2.1), (0.97, 0.4)])
def test_the_voltage_at_constant_current_is_the_equations(soc, current):
    wave = waveform(constant(current, 200.0), soc, 200.0)
    expected = block.integrate(soc, [(200.0, current)], wave["time_s"], wave["current_a"])
    assert len(expected) > 200
    assert wave["voltage_v"] == pytest.approx(expected, abs=1e-8)


def test_pulses_move_the_exponential_zone_both_ways():
    """A slow Reflex, so that each discharge takes the zone down by something."""
    wave = waveform(reflex(0.1, elapsed_s=40.0), 0.5, 40.0)
    segments = [(9.0, 2.1), (0.5, -0.5), (0.5, 0.0)] * 4
    expected = block.integrate(0.5, segments, wave["time_s"], wave["current_a"])
    assert wave["voltage_v"] == pytest.approx(expected, abs=1e-8)
    only_up = block.integrate(0.5, [(9.0, 2.1), (0.5, 0.0), (0.5, 0.0)] * 4, wave["time_s"], wave["current_a"])
    assert np.nanmax(np.abs(only_up - expected)) > 1e-3


def waveform(mode, soc, length_s):
    windows = [{"start_s": 0.0, "length_s": length_s}]
    return charge(GENERIC, mode, settings(soc, windows=windows), engine=TIGHT).waveform


def test_a_lag_of_the_voltage_trails_a_lag_of_the_current_by_what_the_resistance_gains_in_it():
    time = np.linspace(0.0, 9990.0, 1000)
    drawn = np.full(len(time), 2.1)
    ours = block.integrate(0.2, [(9990.0, 2.1)], time, drawn)
    trails = block.integrate(0.2, [(9990.0, 2.1)], time, drawn, lag="current") - ours
    x = 0.8 - 2.1 * time / 3600 / block.Q
    gained = block.TAU * block.K / (x + 0.1) ** 2 * 2.1**2 / (3600 * block.Q)
    later = time > 10 * block.TAU
    assert trails[later] == pytest.approx(gained[later], rel=0.03)
    assert [1e3 * trails[later][0], 1e3 * trails[-1]] == pytest.approx([0.1, 7.8], abs=0.05)


@pytest.mark.parametrize("name", ["lead_acid_generic", "lfp_8ah"])
@pytest.mark.parametrize("mode", ["constant", "reflex"])
def test_a_battery_that_nothing_keeps_below_full_stops_there(name, mode):
    cell = battery(name)
    assert cell.fills
    sheet = constant(2.1, 40_000) if mode == "constant" else reflex(0.7, elapsed_s=40_000)
    found = values(charge(cell, sheet, settings(0.99), engine=TIGHT))
    assert found["end_reason"] == "stop: soc 1"
    assert found["end_soc"] == pytest.approx(1.0, abs=2e-12)
    if mode == "constant":
        assert found["end_time_s"] == pytest.approx(0.01 * cell.capacity_ah * 3600 / 2.1, abs=1e-6)
    assert abs(found["energy_balance_residual"]) < 1e-9


def beyond_full():
    """The same block with SOC counted from 110 %, where its polarisation has its pole, down."""
    wide = load("battery/lead_acid_generic.yaml")
    share = block.K * block.Q / 11
    wide["capacity_ah"] = 1.1 * block.Q
    wide["open_circuit_voltage_v"] = {"full_v": block.E0 + share, "polarisation_v": 10 * share}
    wide["pairs"]["polarisation"]["resistance_ohm"] = {"factor": block.K / 1.1, "depth_offset": 0.0}
    return Battery(**wide)


def test_without_the_stop_the_block_charges_past_full():
    phases = {"charge": {"constant_voltage": {"voltage_v": 14.4, "max_current_a": 2.1}}}
    mode = Mode(title="CC-CV", phases=phases, stop={"elapsed_s": 20_000})
    stopped = values(charge(GENERIC, mode, settings(0.5)))
    assert stopped["end_reason"] == "stop: soc 1"
    assert not beyond_full().fills
    result = charge(beyond_full(), mode, settings(0.5 / 1.1, soc_marks=[1 / 1.1]))
    found = values(result)
    assert found[f"time_to_soc_{1 / 1.1:g}_s"] == pytest.approx(stopped["end_time_s"], abs=1e-4)
    assert found["end_reason"] == "stop: elapsed 20000 s"
    assert 1.05 < 1.1 * found["end_soc"] < 1.1
    assert result.trace["Current / A"][-1] < 0.5


def test_a_sheet_may_ask_for_a_full_battery_where_it_gets_there():
    sheet = constant(2.1, 1000, soc=1.0)
    check(GENERIC, sheet, settings(0.5))
    with pytest.raises(UserError, match=r"stop.soc: 1 is never reached; give less than 1"):
        check(battery("lead_acid_12v7ah"), sheet, settings(0.5))
    with pytest.raises(UserError, match=r"stop.soc: 1.2 is never reached; give 1 or less"):
        check(GENERIC, constant(2.1, 1000, soc=1.2), settings(0.5))


def test_what_the_exponential_zone_takes_is_its_own_path():
    """The integral of A (1 - exp(-B q)) over the charge q."""
    result = charge(GENERIC, constant(2.1, 200.0), settings(0.5), engine=TIGHT)
    heat = dict(zip(result.energy["path"], result.energy["energy_j"], strict=True))["hysteresis"]
    q = 2.1 * 200 / 3600
    assert heat == pytest.approx(3600 * block.A * (q - (1 - np.exp(-block.B * q)) / block.B), rel=1e-8)


def test_it_starts_where_it_is_told():
    full = GENERIC.model_copy(update={"hysteresis": GENERIC.hysteresis.model_copy(update={"initial_share": 1.0})})
    windows = [{"start_s": 0.0, "length_s": 1.0}]
    first = [charge(cell, constant(2.1, 1.0), settings(0.5, windows=windows)).waveform for cell in (GENERIC, full)]
    assert first[1]["voltage_v"][0] - first[0]["voltage_v"][0] == pytest.approx(block.A, abs=1e-12)
