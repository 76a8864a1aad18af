"""Strides over many periods against the same periods one by one, and against closed forms."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import Supply
from tests.charge.samples import BATTERIES, SUITED, battery, charge, load, settings, values
from tests.charge.test_exact import PLAIN

EDGE = EngineSettings(driver="edge", maximum_steps=5_000_000)
AVERAGED = EngineSettings(driver="averaged", maximum_steps=5_000_000)
LEAD = battery("lead_acid_12v7ah")
SHAPES = ["pulse", "reflex"]


def periodic(kind, rate, limit_v, stop_s, frequency_hz=90.0, share=0.9, **stop):
    """Return a mode of pulses or Reflex alone."""
    knobs = {"charge_c_rate": rate, "charge_share": share, "frequency_hz": frequency_hz}
    if kind == "reflex":
        knobs |= {"discharge_c_rate": 0.25 * rate, "discharge_share": 0.05}
    phase = {kind: {}} | ({} if limit_v is None else {"limit": {"voltage_v": limit_v}})
    return Mode(title=kind, phases={"only": phase}, stop={"elapsed_s": stop_s} | stop, **knobs)


def both(cell, mode, conditions, supply=None, engine=AVERAGED):
    more = {} if supply is None else {"supply": supply}
    one = charge(cell, mode, conditions, engine=EDGE.model_copy(update={"tolerance": engine.tolerance}), **more)
    return one, charge(cell, mode, conditions, engine=engine, **more)


def assert_same(one, other, tolerance=1e-6):
    expected, found = values(one), values(other)
    assert found["end_reason"] == expected["end_reason"]
    for name in ("charge_in_ah", "energy_in_wh", "charge_out_ah", "energy_out_wh", "end_time_s"):
        assert found[name] == pytest.approx(expected[name], rel=tolerance), name
    rise = max(0.1, expected["peak_temperature_rise_k"])
    assert found["end_temperature_c"] == pytest.approx(expected["end_temperature_c"], abs=tolerance * rise)
    assert found["peak_temperature_c"] == pytest.approx(expected["peak_temperature_c"], abs=tolerance * rise)
    assert found["end_soc"] == pytest.approx(expected["end_soc"], rel=tolerance)
    assert found["edges"] == expected["edges"]
    # The period in which the limit is first met decides how often it is.
    assert found["time_at_voltage_limit_s"] == pytest.approx(expected["time_at_voltage_limit_s"], rel=1e-4, abs=1e-3)


def worked(result, other, times):
    return values(result)["steps"] < values(other)["steps"] / times


@pytest.mark.parametrize("cell", BATTERIES)
@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("soc", [0.3, None])
def test_it_goes_the_way_of_the_edges(cell, kind, soc):
    rate, voltage, suited = SUITED[cell]
    one, other = both(battery(cell), periodic(kind, rate, voltage, 120.0), settings(soc or suited))
    assert_same(one, other)
    assert worked(other, one, 1.5)
    assert abs(values(other)["energy_balance_residual"]) < 1e-6


@pytest.mark.parametrize("cell", BATTERIES)
def test_the_limit_is_held_for_most_of_the_time(cell):
    rate, _, soc = SUITED[cell]
    low = {"lead_acid_12v7ah": 13.6, "lead_acid_12v18ah": 13.6, "lead_acid_generic": 12.8, "nicd_2s_600mah": 2.85}
    mode = periodic("reflex", rate, low.get(cell, 3.36), 200.0)
    one, other = both(battery(cell), mode, settings(soc))
    assert values(one)["time_at_voltage_limit_s"] > 60.0
    assert_same(one, other)
    assert abs(values(other)["energy_balance_residual"]) < 1e-6


def test_a_nickel_cell_is_overcharged():
    cell, mode = battery("nicd_2s_600mah"), periodic("pulse", 4.0, None, 300.0)
    one, other = both(cell, mode, settings(0.95, ambient_c=30.0))
    assert_same(one, other)
    assert values(other)["end_soc"] > 0.999
    assert worked(other, one, 3)


def test_lead_acid_near_full():
    one, other = both(LEAD, periodic("reflex", 0.3, 14.4, 300.0), settings(0.995))
    assert_same(one, other)
    assert np.mean(one.trace["side_current_a"]) > 0.02 * np.mean(one.trace["Current / A"])
    assert worked(other, one, 2)


@pytest.mark.parametrize("frequency_hz", [0.5, 3.0, 77.3, 900.0])
def test_any_frequency(frequency_hz):
    one, other = both(LEAD, periodic("reflex", 0.3, 14.4, 60.0, frequency_hz), settings(0.9))
    assert_same(one, other)


def test_samples_lie_between_periods():
    mode = periodic("reflex", 0.3, 14.4, 90.0)
    one, other = both(LEAD, mode, settings(0.9, sample_interval_s=3.0, soc_marks=[0.9005, 0.903]))
    assert len(one.trace["soc"]) == len(other.trace["soc"])
    assert other.trace["Test Time / s"] == pytest.approx(one.trace["Test Time / s"], abs=1e-12)
    for name, scale in (
        ("soc", 1e-9),
        ("Charging Capacity / Ah", 1e-9),
        ("Discharging Energy / Wh", 1e-8),
        ("Surface Temperature / degC", 1e-7),
        ("Current / A", 5e-6),
        ("Voltage / V", 5e-6),
        ("voltage_min_v", 1e-3),
        ("voltage_max_v", 1e-3),
        ("current_min_a", 1e-3),
        ("current_max_a", 1e-3),
        ("side_current_a", 5e-6),
        ("voltage_limited_share", 1e-4),
    ):
        assert other.trace[name] == pytest.approx(one.trace[name], abs=scale), name
    expected, found = values(one), values(other)
    for mark in (0.9005, 0.903):
        # Discharging pulses let the first moment lie in the period before.
        assert found[f"time_to_soc_{mark:g}_s"] == pytest.approx(expected[f"time_to_soc_{mark:g}_s"], abs=1 / 90)
        rise = f"temperature_rise_at_soc_{mark:g}_k"
        assert found[rise] == pytest.approx(expected[rise], rel=1e-3)


@pytest.mark.parametrize("frequency_hz", [0.3, 1.3, 1.99])
@pytest.mark.parametrize("cell", BATTERIES)
def test_samples_and_marks_inside_long_periods_are_as_exact_as_the_end(cell, frequency_hz):
    rate, voltage, _ = SUITED[cell]
    mode = periodic("reflex", rate, voltage, 300.0, frequency_hz, share=0.5)
    one, other = both(battery(cell), mode, settings(0.5, sample_interval_s=37.3, soc_marks=[0.505]))
    for name, scale in (("soc", 1e-10), ("Charging Energy / Wh", 1e-6), ("Current / A", 1e-7), ("voltage_max_v", 1e-3)):
        assert other.trace[name] == pytest.approx(one.trace[name], abs=scale, rel=1e-8), name
    mark = "time_to_soc_0.505_s"
    assert values(other)[mark] == pytest.approx(values(one)[mark], abs=1e-7)


def test_windows_are_seen_in_full():
    windows = [{"start_s": 30.003, "length_s": 0.04}, {"start_s": 51.0, "length_s": 0.02}]
    one, other = both(LEAD, periodic("reflex", 0.3, 14.4, 60.0), settings(0.9, windows=windows))
    assert len(other.waveform["time_s"]) == len(one.waveform["time_s"])
    for name in ("time_s", "current_a", "voltage_v", "soc", "temperature_c"):
        assert other.waveform[name] == pytest.approx(one.waveform[name], rel=1e-6), name


@pytest.mark.parametrize(
    ("stop", "soc", "limit_v"),
    [
        ({"soc": 0.81}, 0.8, 14.4),
        ({"voltage_v": 13.9}, 0.8, None),
        ({"temperature_c": 25.05}, 0.8, 14.4),
        ({"current_a": 1.0}, 0.95, 14.4),
        ({"soc": 0.953}, 0.95, 14.4),
        ({}, 0.8, 14.4),
    ],
)
def test_a_stop_is_located_as_by_the_edges(stop, soc, limit_v):
    one, other = both(LEAD, periodic("reflex", 0.3, limit_v, 333.337, **stop), settings(soc))
    assert values(one)["end_reason"] == values(other)["end_reason"]
    assert (values(one)["end_time_s"] == pytest.approx(333.337)) == (not stop)
    assert values(other)["end_time_s"] == pytest.approx(values(one)["end_time_s"], abs=1.01 / 90)
    assert worked(other, one, 1.5)


def test_a_peak_of_the_voltage_between_nodes_is_a_stop():
    cell = battery("nicd_2s_600mah")
    conditions = settings(0.9, ambient_c=30.0)
    free = charge(cell, periodic("pulse", 4.0, None, 300.0), conditions, engine=AVERAGED)
    highest = free.trace["voltage_max_v"].max()
    mode = periodic("pulse", 4.0, None, 300.0, voltage_v=float(highest) - 1e-3)
    one, other = both(cell, mode, conditions)
    assert "voltage" in values(one)["end_reason"]
    assert values(other)["end_time_s"] == pytest.approx(values(one)["end_time_s"], abs=1.01 / 90)


def test_a_supply_that_changes_is_followed():
    supply = Supply(np.array([0.0, 40.0, 80.005]), np.array([1e9, 20.0, 25.0]))
    one, other = both(LEAD, periodic("reflex", 0.3, 14.4, 120.0), settings(0.5), supply=supply)
    assert values(one)["time_at_supply_limit_s"] > 50.0
    assert values(other)["time_at_supply_limit_s"] == pytest.approx(values(one)["time_at_supply_limit_s"], rel=1e-6)
    assert_same(one, other)


@pytest.mark.parametrize("driver", ["edge", "averaged"])
@pytest.mark.parametrize("frequency_hz", [0.2, 1.0, 5.0, 20.0, 90.0])
@pytest.mark.parametrize("cell", BATTERIES)
def test_all_that_a_supply_at_its_limit_gives_is_put_in(cell, frequency_hz, driver):
    """Power times the time of charging, at the default tolerance: fast pairs bend the current of long pulses."""
    rate, voltage, _ = SUITED[cell]
    power_w = 0.5 * rate * battery(cell).capacity_in_use_ah * voltage
    supply = Supply(np.zeros(1), np.full(1, power_w))
    mode = periodic("pulse", rate, 1.1 * voltage, 60.0, frequency_hz)
    found = values(charge(battery(cell), mode, settings(0.5), supply, EngineSettings(driver=driver)))
    assert found["time_at_supply_limit_s"] == pytest.approx(54.0, rel=1e-9)
    assert found["energy_in_wh"] == pytest.approx(power_w * 54.0 / 3600.0, rel=3e-7)


def test_phases_of_both_kinds_follow_each_other():
    sheet = load("modes/cv_reflex_hourly.yaml")
    for phase in sheet["phases"].values():
        phase["until"]["elapsed_s"] = 20.0
    mode = Mode(**(sheet | {"stop": {"elapsed_s": 90.0}}))
    one, other = both(LEAD, mode, settings(0.8))
    assert_same(one, other)
    assert other.phases["end_s"] == pytest.approx(one.phases["end_s"], abs=1e-9)


def test_charge_by_pulses_is_counted_exactly():
    found = values(charge(Battery(**PLAIN), periodic("pulse", 0.5, None, 1800.0), settings(0.1), engine=AVERAGED))
    assert found["charge_in_ah"] == pytest.approx(0.9 * 0.25, rel=1e-12)
    assert found["end_soc"] == pytest.approx(0.1 + 0.9 * 0.25, rel=1e-12)


def test_pulses_warm_a_cooled_battery_by_the_exponential():
    cooled = Battery(**(PLAIN | {"thermal": {"heat_capacity_j_k": 100.0, "resistance_k_w": 3.0}}))
    mode = periodic("pulse", 2.0, None, 900.0)
    trace = charge(cooled, mode, settings(0.1), engine=AVERAGED).trace
    # Mean heat 0.9 x 2 x 0.05 x 2^2 W; within a period the rise follows the pulse, a microkelvin from the mean.
    expected = 25.0 + 0.36 * 3.0 * -np.expm1(-trace["Test Time / s"] / 300.0)
    assert trace["Surface Temperature / degC"] == pytest.approx(expected, abs=5e-6)


@pytest.mark.parametrize("time_constant_s", [0.002, 0.3, 40.0])
def test_a_pair_follows_pulses_by_its_exact_map(time_constant_s):
    pair = {"only": {"resistance_ohm": 0.1, "time_constant_s": time_constant_s}}
    cell = Battery(**(PLAIN | {"pairs": pair, "open_circuit_voltage_v": 2.0}))
    # Half a second before a whole number of seconds there is nothing but whole periods.
    window = [{"start_s": 60.0, "length_s": 0.001}]
    wave = charge(cell, periodic("pulse", 0.5, None, 61.0), settings(0.1, windows=window), engine=AVERAGED).waveform
    period, count = 1 / 90, 60 * 90
    on, of_period = np.exp(-0.9 * period / time_constant_s), np.exp(-period / time_constant_s)
    gain = 0.05 * (1 - on) * np.exp(-0.1 * period / time_constant_s)
    before = gain * (1 - of_period**count) / (1 - of_period)
    first = int(np.argmin(np.abs(wave["time_s"] - 60.0)))
    later = wave["time_s"][first:] - 60.0
    expected = 2.0 + 0.05 * 0.5 + 0.05 + (before - 0.05) * np.exp(-later / time_constant_s)
    assert wave["voltage_v"][first:] == pytest.approx(2 * expected, abs=2e-10)


def test_auto_strides_above_two_hertz():
    for frequency, strides in ((1.5, False), (3.0, True)):
        mode = periodic("reflex", 0.3, 14.4, 120.0, frequency)
        auto = values(charge(LEAD, mode, settings(0.3), engine=EngineSettings()))["steps"]
        edge = values(charge(LEAD, mode, settings(0.3), engine=EDGE))["steps"]
        assert (auto < edge) == strides
    assert EngineSettings().driver == "auto"


def test_its_work_does_not_grow_with_the_frequency():
    steps = [
        values(charge(LEAD, periodic("reflex", 0.3, 14.4, 300.0, f), settings(0.3), engine=AVERAGED))["steps"]
        for f in (20.0, 500.0)
    ]
    assert steps[1] < 1.5 * steps[0]


@pytest.mark.parametrize(("initial_soc", "limit_v"), [(0.3, None), (0.85, 13.9)])
def test_a_tighter_tolerance_asks_for_more_strides_not_for_every_period(initial_soc, limit_v):
    mode = periodic("reflex", 0.3, limit_v, 1800.0, 90.0)
    steps = {
        tolerance: values(charge(LEAD, mode, settings(initial_soc), engine=EngineSettings(tolerance=tolerance)))
        for tolerance in (1e-6, 1e-7, 1e-8)
    }
    for tolerance, found in steps.items():
        assert found["steps"] < 1e-2 * found["edges"] * (1e-6 / tolerance) ** 0.5, tolerance
    assert steps[1e-6]["energy_in_wh"] == pytest.approx(steps[1e-8]["energy_in_wh"], rel=1e-6)
