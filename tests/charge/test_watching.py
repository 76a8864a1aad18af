"""Stops on a falling voltage and on the rate of temperature, against a charge followed in fine steps."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.records import EngineSettings, Mode
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, load, settings, values
from tests.charge.test_exact import PLAIN

NICKEL = battery("nicd_2s_600mah")
AT_30 = {"ambient_c": 30.0, "sample_interval_s": 5.0}


def constant(rate, seconds, **stop):
    phases = {"charge": {"constant_current": {}}}
    return Mode(title="Constant", current_c_rate=rate, phases=phases, stop={"elapsed_s": seconds} | stop)


FINE_S = 0.05


@pytest.fixture(scope="module", params=[4.0, 8.0])
def fine(request):
    """A charge through its voltage peak, sampled and stepped twenty times a second: rate, time, voltage, temperature.

    Voltages are means over an interval, so they stand in its middle.
    """
    rate = request.param
    engine = EngineSettings(tolerance=1e-11, maximum_step_s=FINE_S)
    conditions = settings(0.02, ambient_c=30.0, sample_interval_s=FINE_S)
    trace = charge(NICKEL, constant(rate, 1.1 * 3600 / rate), conditions, engine=engine).trace
    return rate, trace["Test Time / s"], trace["Voltage / V"], trace["Surface Temperature / degC"]


def first_crossing(time, values_over, level):
    """Return when values first pass a level, linear between samples."""
    place = int(np.argmax(values_over >= level))
    share = (level - values_over[place - 1]) / (values_over[place] - values_over[place - 1])
    return time[place - 1] + share * (time[place] - time[place - 1])


def test_the_fall_of_the_voltage_is_located(fine):
    rate, time, voltage, _ = fine
    expected = first_crossing(time - FINE_S / 2, np.maximum.accumulate(voltage) - voltage, 0.02)
    found = values(charge(NICKEL, constant(rate, 2000, voltage_drop_v=0.02), settings(0.02, **AT_30)))
    assert found["end_time_s"] == pytest.approx(expected, abs=5e-3)
    assert found["end_reason"] == "stop: voltage below its peak by 0.02 V"


@pytest.mark.parametrize("limit", [0.05, 0.1])
def test_the_rate_of_the_temperature_is_located(fine, limit):
    rate, time, _, temperature = fine
    slope = (temperature[4:] - temperature[:-4]) / (4 * FINE_S)
    expected = first_crossing(time[2:-2], slope, limit)
    found = values(charge(NICKEL, constant(rate, 2000, temperature_rate_k_s=limit), settings(0.02, **AT_30)))
    assert found["end_time_s"] == pytest.approx(expected, abs=5e-3)
    assert found["end_reason"] == f"stop: temperature rate {limit:g} K/s"


def test_the_rate_has_a_closed_form():
    """The heat of a resistor is there at once, that of a pair grows with the square of its voltage."""
    paired = Battery(**(PLAIN | {"pairs": {"only": {"resistance_ohm": 0.1, "time_constant_s": 7.0}}}))
    # The pair's heat is v^2 / R = 0.1 (1 - exp(-t / 7))^2 I^2; half its voltage is there after 7 ln 2 s.
    limit = 2 * 4 * (0.05 + 0.1 * 0.5**2) / 100
    mode = Mode(
        title="Rate",
        phases={"charge": {"constant_current": {"current_a": 2.0}}},
        stop={"elapsed_s": 600, "temperature_rate_k_s": limit},
    )
    found = values(charge(paired, mode, settings(0.1)))
    assert found["end_time_s"] == pytest.approx(7.0 * np.log(2.0), abs=1e-6)


def test_a_rate_already_there_ends_a_phase_at_once():
    phases = {
        "fast": {"constant_current": {"current_a": 4.8}, "until": {"temperature_rate_k_s": 0.01}},
        "slow": {"constant_current": {"current_a": 0.6}, "until": {"elapsed_s": 20}},
    }
    result = charge(NICKEL, Mode(title="Two", phases=phases, stop={"elapsed_s": 100}), settings(0.02, **AT_30))
    assert result.phases["end_s"] == pytest.approx([0.0, 20.0], abs=1e-9)
    assert result.phases["end_reason"] == ["temperature rate 0.01 K/s, met as it began", "elapsed 20 s"]


def test_a_lowered_current_is_no_falling_voltage():
    phases = {"stages": {"staged": {"currents_a": [4.8, 2.4, 1.2], "soc_edges": [0.3, 0.5, 0.7]}}}
    mode = Mode(title="Staged", phases=phases, stop={"elapsed_s": 5000, "voltage_drop_v": 0.02})
    found = values(charge(NICKEL, mode, settings(0.1, **AT_30)))
    assert found["end_reason"] == "soc 0.7"


def test_watching_changes_nothing_before_it_acts():
    plain = charge(NICKEL, constant(4.0, 800), settings(0.02, **AT_30))
    seen = charge(NICKEL, constant(4.0, 800, voltage_drop_v=0.5, temperature_rate_k_s=5.0), settings(0.02, **AT_30))
    for name in plain.trace:
        assert np.array_equal(plain.trace[name], seen.trace[name]), name


@pytest.mark.parametrize("key", ["voltage_drop_v", "temperature_rate_k_s"])
def test_pulses_are_refused(key):
    sheet = load("modes/cv_reflex.yaml")
    lead = battery("lead_acid_12v7ah")
    sheet["stop"] |= {key: 0.05}
    with pytest.raises(UserError, match=rf"^stop\.{key}: needs a steady current; pulses"):
        check(lead, Mode(**sheet), settings(0.2))
    sheet["stop"].pop(key)
    sheet["phases"]["reflex"]["until"] = {key: 0.05}
    with pytest.raises(UserError, match=rf"^phases\.reflex\.until\.{key}: needs a steady current"):
        check(lead, Mode(**sheet), settings(0.2))


@pytest.mark.parametrize("key", ["voltage_drop_v", "temperature_rate_k_s"])
def test_a_value_that_is_no_fall_and_no_rise_is_refused(key):
    with pytest.raises(UserError, match=rf"^stop\.{key}: -0.02; it must be greater than 0"):
        check(NICKEL, constant(4.0, 800, **{key: -0.02}), settings(0.2))
