"""What a charger of nickel cells watches and samples in a day: in changing air, at a limit, over a pause."""

import numpy as np
import pytest

from pipeline.bus.flows import ENDED, OFF
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Supply, simulate
from pipeline.day.charge import charge_over_day
from tests.charge.samples import battery, load
from tests.charge.test_controller import NETWORK, response
from tests.day.samples import CONDITIONS, sun

NICKEL = battery("nicd_2s_600mah")
AT = CONDITIONS.model_copy(update={"initial_soc": 0.05, "ambient_step_s": 90.0, "sample_interval_s": 1.0})
AMPLE_W = 50.0


def of_study(name, **more):
    sheet = load(f"modes/{name}.yaml") | more
    return Mode(**(sheet | ({"phases": {"charge": {"controller": {"network": NETWORK}}}} if name == "grnn" else {})))


MODES = {
    "-dV": of_study("constant_4c", stop={"elapsed_s": 9e3, "voltage_drop_v": 0.02}),
    "dT/dt": of_study("constant_4c", stop={"elapsed_s": 9e3, "temperature_rate_k_s": 0.05}),
    "plain rule": of_study("plain_rule"),
    "plain rule, slow samples": of_study("plain_rule", sample_interval_s=20.0, temperature_noise_k=0.01),
    "network": of_study("grnn", sample_interval_s=7.0, rate_span_s=21.0),
}


def day(mode, around, conditions=AT):
    return charge_over_day(NICKEL, mode, around, conditions, EngineSettings())


@pytest.mark.parametrize("name", MODES)
def test_a_change_of_the_air_makes_nobody_forget(name):
    """The air changes by nothing to speak of, every minute and a half: the day is the plain charge."""
    mode = MODES[name]
    air = 30.0 + 1e-9 * (np.arange(20) % 2)
    found = day(mode, sun(np.full(20, AMPLE_W), interval_s=90.0, ambient_c=air))
    settings = ChargeSettings(initial_soc=0.05, ambient_c=30.0, sample_interval_s=1.0)
    plain = simulate(NICKEL, mode, BENCH, settings, EngineSettings())
    expected = {one.quantity: one.value if one.text is None else one.text for one in plain.summary}
    whole = int(expected["end_time_s"])
    assert found.trace["Current / A"][:whole] == pytest.approx(plain.trace["Current / A"][:whole], rel=1e-6)
    assert found.trace["soc"][:whole] == pytest.approx(plain.trace["soc"][:whole], rel=1e-7)
    assert whole < 1800
    if "elapsed" not in expected["end_reason"]:
        assert found.changes[-1].after == ENDED
        assert found.changes[-1].time_s == pytest.approx(expected["end_time_s"], abs=1e-3)
        assert found.changes[-1].reason == expected["end_reason"]


@pytest.mark.parametrize("name", ["-dV", "dT/dt"])
def test_the_signs_of_full_are_met(name):
    assert day(MODES[name], sun(np.full(20, AMPLE_W), interval_s=90.0, ambient_c=30.0)).changes[-1].after == ENDED


def test_a_sun_that_dims_is_no_sign_of_full():
    """A part of the power lowers the current and the voltage with it, by far more than is watched for."""
    powers = [AMPLE_W] * 4 + [4.0, 3.0, 2.5] + [AMPLE_W] * 13
    found = day(MODES["-dV"], sun(powers, interval_s=90.0, ambient_c=30.0))
    voltage, time = found.trace["Voltage / V"], found.trace["Test Time / s"]
    assert voltage[time < 360.0].max() - voltage[(time > 370.0) & (time < 620.0)].min() > 0.05
    assert (found.changes[-1].after, found.changes[-1].reason) == (ENDED, "stop: voltage below its peak by 0.02 V")
    # Full is met as without the clouds: at the same charge, where the current is the same again.
    bright = day(MODES["-dV"], sun(np.full(20, AMPLE_W), interval_s=90.0, ambient_c=30.0))
    assert found.charge_in_ah == pytest.approx(bright.charge_in_ah, rel=0.02)


def test_a_dim_supply_ends_no_plain_charge():
    settings = ChargeSettings(initial_soc=0.05, ambient_c=30.0, sample_interval_s=10.0)
    supply = Supply(np.array([0.0, 300.0, 310.0, 320.0]), np.array([AMPLE_W, 5.0, 4.0, 3.0]))
    mode = MODES["-dV"].model_copy(update={"stop": MODES["-dV"].stop.model_copy(update={"elapsed_s": 600.0})})
    found = {one.quantity: one.text for one in simulate(NICKEL, mode, supply, settings, EngineSettings()).summary}
    assert found["end_reason"] == "stop: elapsed 600 s"


def test_pauses_are_no_time_at_a_limit():
    """What flows at rest is rounding: the three limits share the time of charging, to the last step."""
    conditions = AT.model_copy(update={"initial_soc": 0.5})
    found = day(MODES["dT/dt"], sun([AMPLE_W, 0.3] * 5, interval_s=120.0, ambient_c=30.0), conditions)
    assert sum(change.after == OFF for change in found.changes) > 1
    shares = found.current_limited_s + found.voltage_limited_s + found.supply_limited_s
    assert shares == pytest.approx(found.charging_s, rel=1e-9)


def test_readings_do_not_hold_over_a_pause():
    """After a cloud the network sees the temperature and no rate, though the battery has cooled in between."""
    around = sun([AMPLE_W] * 2 + [0.0] * 5 + [AMPLE_W] * 2, interval_s=90.0, ambient_c=30.0)
    conditions = AT.model_copy(update={"initial_soc": 0.3})
    found = day(MODES["network"], around, conditions)
    time, current = found.trace["Test Time / s"], found.trace["Current / A"]
    warm = found.trace["Surface Temperature / degC"]
    at = int(np.searchsorted(time, 631.0))
    assert OFF in {change.after for change in found.changes}
    assert current[at] == pytest.approx(0.6 * response(warm[at - 1], 0.0), rel=1e-6)


def test_a_rule_that_has_switched_stays_so():
    rule = of_study("plain_rule", trip_rate_k_s=0.001)
    found = day(rule, sun([AMPLE_W] * 2 + [0.0] * 5 + [AMPLE_W] * 2, interval_s=90.0, ambient_c=30.0))
    time, current = found.trace["Test Time / s"], found.trace["Current / A"]
    assert current[time < 10.5].max() > 1.0
    assert current[(time > 20.0)].max() == pytest.approx(0.06, rel=1e-9)
    assert current[time > 640.0].max() == pytest.approx(0.06, rel=1e-9)
