"""Every stop under every driver: edge finds it to a millisecond, averaged to a period."""

import numpy as np
import pytest

from pipeline.charge.records import EngineSettings, Mode
from tests.charge.samples import battery, charge, settings, values

LEAD, NICKEL = battery("lead_acid_12v7ah"), battery("nicd_2s_600mah")
DRIVERS = ["edge", "averaged"]
HERTZ = 90.0
# What the default tolerance is held against.
FINE = {"tolerance": 1e-11, "maximum_step_s": 0.25, "maximum_steps": 20_000_000}

# Stop, its value, SOC at the start, voltage limit: each met well within the time.
PULSED = [
    ("elapsed_s", 222.2222, 0.8, 14.4),
    ("soc", 0.8123, 0.8, 14.4),
    ("voltage_v", 13.8, 0.8, None),
    ("current_a", 1.2, 0.95, 14.4),
    ("temperature_c", 25.04, 0.8, 14.4),
]
STEADY = [
    ("elapsed_s", 222.2222, LEAD, 0.3, 0.8),
    ("soc", 0.8123, LEAD, 0.3, 0.8),
    ("voltage_v", 13.5, LEAD, 0.3, 0.8),
    ("current_a", 1.2, LEAD, 0.3, 0.95),
    ("temperature_c", 25.04, LEAD, 0.3, 0.8),
    ("voltage_drop_v", 0.02, NICKEL, 4.0, 0.9),
    ("temperature_rate_k_s", 0.05, NICKEL, 4.0, 0.9),
]


def pulsed(stop, value, limit_v):
    knobs = {"charge_c_rate": 0.3, "charge_share": 0.9, "discharge_c_rate": 0.07, "discharge_share": 0.05}
    phase = {"reflex": {}} | ({} if limit_v is None else {"limit": {"voltage_v": limit_v}})
    return Mode(
        title="Pulsed", frequency_hz=HERTZ, phases={"only": phase}, stop={"elapsed_s": 900.0} | {stop: value}, **knobs
    )


def steady(stop, value, cell, rate):
    # The current falls where a voltage is held; the others are met at a constant one.
    kind, limit = ("constant_voltage", {"voltage_v": 14.4}) if stop == "current_a" else ("constant_current", {})
    knob = "max_current_c_rate" if stop == "current_a" else "current_c_rate"
    return Mode(
        title="Steady",
        phases={"only": {kind: limit}},
        stop={"elapsed_s": 3000.0} | {stop: value},
        **{knob: rate},
    )


def ended(cell, mode, soc, **engine):
    found = values(charge(cell, mode, settings(soc), engine=EngineSettings(**engine)))
    return found["end_time_s"], found["end_reason"]


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize(("stop", "value", "soc", "limit_v"), PULSED)
def test_a_stop_of_pulses(driver, stop, value, soc, limit_v):
    mode = pulsed(stop, value, limit_v)
    expected, why = ended(LEAD, mode, soc, driver="edge", **FINE)
    found, reason = ended(LEAD, mode, soc, driver=driver)
    assert reason == why
    assert f"{value:g}" in reason
    assert found == pytest.approx(expected, abs=1e-3 if driver == "edge" else 1.0 / HERTZ)


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize(("stop", "value", "cell", "rate", "soc"), STEADY)
def test_a_stop_of_a_steady_current(driver, stop, value, cell, rate, soc):
    mode = steady(stop, value, cell, rate)
    expected, why = ended(cell, mode, soc, driver="edge", **FINE)
    found, reason = ended(cell, mode, soc, driver=driver)
    assert reason == why
    assert f"{value:g}" in reason
    assert found == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("stop", ["voltage_drop_v", "temperature_rate_k_s"])
def test_what_is_watched_goes_by_edges_under_either_driver(stop):
    mode = steady(stop, 0.03, NICKEL, 4.0)
    one, other = (charge(NICKEL, mode, settings(0.8), engine=EngineSettings(driver=driver)) for driver in DRIVERS)
    for name in one.trace:
        assert np.array_equal(one.trace[name], other.trace[name]), name
    assert values(one) == values(other)
