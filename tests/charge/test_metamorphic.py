"""What must not change when a charge is said in another way."""

import numpy as np
import pytest

from pipeline.charge.comparison import at_same_mean
from pipeline.charge.records import Mode
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, load, settings, values

LEAD = battery("lead_acid_12v7ah")


def periodic(kind, stop_s=20.0, **knobs):
    phases = {"only": {kind: {}, "limit": {"voltage_v": 14.4}}}
    return Mode(title=kind, phases=phases, stop={"elapsed_s": stop_s}, **knobs)


def test_a_pulse_that_fills_its_period_is_constant_current():
    pulse = charge(LEAD, periodic("pulse", charge_a=2.1, charge_share=1.0, frequency_hz=90), settings(0.5))
    steady = charge(LEAD, periodic("constant_current", current_a=2.1), settings(0.5))
    for name in pulse.trace:
        assert np.array_equal(pulse.trace[name], steady.trace[name])


def test_reflex_without_discharge_is_a_pulse():
    knobs = {"charge_a": 2.1, "charge_share": 0.8, "frequency_hz": 90}
    pulse = charge(LEAD, periodic("pulse", **knobs), settings(0.5))
    reflex = charge(LEAD, periodic("reflex", discharge_a=0.5, discharge_share=0.0, **knobs), settings(0.5))
    for name in pulse.trace:
        assert np.array_equal(pulse.trace[name], reflex.trace[name])


def test_a_battery_of_larger_plates_goes_the_same_way_at_the_same_rate():
    large = battery("lead_acid_12v18ah")
    knobs = {"charge_share": 0.9, "discharge_share": 0.05, "frequency_hz": 90}
    one = charge(LEAD, periodic("reflex", charge_a=2.1, discharge_a=0.5, **knobs), settings(0.9))
    k = 18 / 7
    other = charge(large, periodic("reflex", charge_a=2.1 * k, discharge_a=0.5 * k, **knobs), settings(0.9))
    for name in ("Voltage / V", "soc", "Surface Temperature / degC", "voltage_max_v"):
        assert other.trace[name] == pytest.approx(one.trace[name], rel=1e-11)
    assert other.trace["Current / A"] == pytest.approx(k * one.trace["Current / A"], rel=1e-11)


def test_sampling_and_windows_change_nothing():
    knobs = {"charge_a": 2.1, "charge_share": 0.9, "discharge_a": 0.5, "discharge_share": 0.05, "frequency_hz": 90}
    mode = periodic("reflex", **knobs)
    plain = values(charge(LEAD, mode, settings(0.5)))
    windows = [{"start_s": 3.21, "length_s": 0.1}]
    seen = values(charge(LEAD, mode, settings(0.5, windows=windows, sample_interval_s=0.77)))
    for name in ("end_soc", "energy_in_wh", "charge_in_ah"):
        assert seen[name] == pytest.approx(plain[name], rel=1e-12)
    assert seen["end_temperature_c"] == pytest.approx(plain["end_temperature_c"], abs=1e-12 * 298)


def test_a_window_shows_both_sides_of_every_edge():
    knobs = {"charge_a": 2.1, "charge_share": 0.9, "discharge_a": 0.5, "discharge_share": 0.05, "frequency_hz": 90}
    windows = [{"start_s": 1.0, "length_s": 1 / 90}]
    wave = charge(LEAD, periodic("reflex", **knobs), settings(0.5, windows=windows)).waveform
    twice = np.nonzero(np.abs(np.diff(wave["time_s"])) < 1e-12)[0]
    jumps = [(wave["current_a"][n], wave["current_a"][n + 1]) for n in twice]
    assert jumps == [pytest.approx((2.1, -0.5), abs=1e-12), pytest.approx((-0.5, 0.0), abs=1e-12)]
    assert len(wave["time_s"]) >= 24 * 3
    assert np.all(np.diff(wave["time_s"]) >= -1e-12)


def test_the_same_mean_is_the_mean_of_a_period():
    mode = at_same_mean(Mode(**load("modes/cv_reflex.yaml")), 2.1, 7.0)
    knobs = mode.knobs
    mean = knobs["charge_a"] * knobs["charge_share"] - knobs["discharge_a"] * knobs["discharge_share"]
    assert mean == pytest.approx(2.1, rel=1e-14)
    steady = Mode(**load("modes/cc_cv.yaml"))
    assert at_same_mean(steady, 2.1, 7.0) is steady
    unknown = load("modes/cv_reflex.yaml") | {"charge_share": {"from": "search", "value": "share"}}
    with pytest.raises(UserError, match="charge_share: still to be found"):
        at_same_mean(Mode(**unknown), 2.1, 7.0)
