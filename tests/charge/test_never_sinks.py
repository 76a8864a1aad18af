"""A charger never draws from the battery, whatever it holds: against scipy, every waveform, every battery."""

import numpy as np
import pytest

from pipeline.bus.records import Switching
from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Supply
from pipeline.charge.waveforms import WAVEFORMS as CATALOGUE
from pipeline.day.charge import charge_over_day
from pipeline.day.records import DayConditions
from tests.charge.clamped import Reference
from tests.charge.samples import BATTERIES, SUITED, battery, charge, settings, values
from tests.charge.test_exact import PLAIN
from tests.day.samples import sun

BEGIN_S, SPAN_S, HERTZ = 20.0, 12.0, 5.0
PULSED = {"charge_share": 0.6, "frequency_hz": HERTZ}
WAVEFORMS = {
    "constant_current": lambda a, v: {"current_a": a},
    "constant_voltage": lambda a, v: {"max_current_a": a, "voltage_v": v},
    "constant_power": lambda a, v: {"power_w": a * v},
    "pulse": lambda a, v: PULSED | {"charge_a": a},
    "reflex": lambda a, v: PULSED | {"charge_a": a, "discharge_a": 0.3 * a, "discharge_share": 0.2},
    "staged": lambda a, v: {"currents_a": [a], "soc_edges": [0.999]},
    "controller": lambda a, v: {"sample_interval_s": 1.0},
    "rate_switch": lambda a, v: {"sample_interval_s": 1.0, "fast_a": a, "trickle_a": 0.1 * a, "trip_rate_k_s": 10.0},
}


def network(rate):
    """Return a network that commands the same rate everywhere."""
    ends = {"low": [0.0, -1.0], "high": [50.0, 1.0], "widths": [1.0, 1.0], "gradient_seconds": 60.0}
    return ends | {"centres": [[25.0, 0.0]], "outputs_c_rate": [rate]}


def test_every_waveform_is_here():
    assert {*WAVEFORMS, "rest"} == set(CATALOGUE)


def amperes(name):
    return SUITED[name][0] * battery(name).capacity_in_use_ah


def begun(name, soc=0.8):
    """Return the reference after a constant current, and a voltage that it relaxes to within the next seconds."""
    own = Reference(battery(name), soc)
    own.run(BEGIN_S, amperes(name))
    state = own.y.copy()
    own.run(0.3 * SPAN_S, 0.0, charging=False)
    volts = own.b.cells_in_series * own.at(own.y, total=0.0)[3]
    own.y = state
    return own, float(volts)


def sheet(waveform, name, volts):
    own = WAVEFORMS[waveform](amperes(name), volts)
    if waveform == "controller":
        own |= {"network": network(SUITED[name][0])}
    phases = {
        "begin": {"constant_current": {"current_a": amperes(name)}, "until": {"elapsed_s": BEGIN_S}},
        "low": {waveform: own, "limit": {"voltage_v": volts}},
    }
    return Mode(title=waveform, phases=phases, stop={"elapsed_s": BEGIN_S + SPAN_S})


def follow(own, waveform, amperes, volts, power_w=np.inf):
    if waveform in ("pulse", "reflex"):
        for _ in range(round(SPAN_S * HERTZ)):
            own.run(0.6 / HERTZ, amperes, volts, power_w=power_w)
            if waveform == "reflex":
                own.run(0.2 / HERTZ, -0.3 * amperes, charging=False)
            own.run((0.2 if waveform == "reflex" else 0.4) / HERTZ, 0.0, charging=False)
    else:
        own.run(SPAN_S, amperes, volts, power_w=power_w)
    return own.result()


@pytest.mark.parametrize("name", BATTERIES)
@pytest.mark.parametrize("waveform", WAVEFORMS)
def test_it_agrees_with_scipy_that_clamps(waveform, name):
    own, volts = begun(name)
    expected = follow(own, waveform, amperes(name), volts)
    drivers = ["edge", "averaged"] if waveform in ("pulse", "reflex") else ["edge"]
    for driver in drivers:
        made = charge(
            battery(name), sheet(waveform, name, volts), settings(0.8, sample_interval_s=1.0),
            engine=EngineSettings(driver=driver),
        )  # fmt: skip
        found = values(made)
        assert found["end_soc"] == pytest.approx(expected["end_soc"], abs=2e-8)
        assert found["end_temperature_c"] == pytest.approx(expected["end_temperature_c"], abs=2e-6)
        assert found["charge_in_ah"] == pytest.approx(expected["charge_in_ah"], rel=2e-6)
        assert found["charge_out_ah"] == pytest.approx(expected["charge_out_ah"], rel=1e-9, abs=1e-14)
        energy = found["energy_in_wh"] - found["energy_out_wh"]
        assert energy == pytest.approx(expected["energy_wh"], rel=2e-6)
        least = -0.3 * amperes(name) if waveform == "reflex" else 0.0
        assert np.min(made.trace["current_min_a"]) == pytest.approx(least, rel=1e-9, abs=1e-11)
        if waveform in ("constant_current", "constant_voltage"):
            low = made.trace["Current / A"][made.trace["Test Time / s"] > BEGIN_S + 0.5]
            assert low[0] == 0.0
            assert low[-1] > 0.0


@pytest.mark.parametrize("name", BATTERIES)
def test_nor_does_it_from_a_supply_at_its_limit(name):
    own, volts = begun(name)
    power_w = 0.05 * amperes(name) * volts
    expected = follow(own, "pulse", amperes(name), volts, power_w)
    supply = Supply(np.array([0.0, BEGIN_S]), np.array([np.inf, power_w]))
    for driver in ("edge", "averaged"):
        made = charge(battery(name), sheet("pulse", name, volts), settings(0.8), supply, EngineSettings(driver=driver))
        found = values(made)
        assert found["end_soc"] == pytest.approx(expected["end_soc"], abs=2e-8)
        assert found["energy_in_wh"] == pytest.approx(expected["energy_wh"], rel=2e-6)
        assert np.min(made.trace["current_min_a"]) > -1e-12  # a rest, to rounding


def test_a_float_after_absorption_waits_for_the_battery():
    """14.4 V, then 13.2 V: the case that drew 47.7 A."""
    phases = {
        "bulk": {"constant_voltage": {"voltage_v": 14.4, "max_current_a": 2.1}, "until": {"current_a": 0.35}},
        "float": {"constant_voltage": {"voltage_v": 13.2, "max_current_a": 2.1}},
    }
    mode = Mode(title="float", phases=phases, stop={"elapsed_s": 40000})
    made = charge(battery("lead_acid_12v7ah"), mode, settings(0.8), BENCH)
    trace, start_s = made.trace, made.phases["start_s"][1]
    after = trace["Test Time / s"] > start_s + 10
    current, voltage = trace["Current / A"][after], trace["Voltage / V"][after]
    assert np.min(trace["current_min_a"]) == 0.0
    assert current[0] == 0.0
    assert voltage[0] > 13.2
    assert 0.0 < current[-1] < 0.02
    assert voltage[-1] == pytest.approx(13.2, abs=1e-9)


@pytest.mark.parametrize("waveform", ["constant_current", "constant_voltage", "pulse", "reflex"])
def test_the_instant_of_the_release_is_located(waveform):
    """A pair relaxes by the exponential: it is at the limit after five seconds, whatever was tried before."""
    pair = {"only": {"resistance_ohm": 0.1, "time_constant_s": 7.0}}
    cell = Battery(**(PLAIN | {"open_circuit_voltage_v": 2.0, "pairs": pair}))
    above = 0.1 * 0.5 * -np.expm1(-20.0 / 7.0) * np.exp(-5.0 / 7.0)
    if waveform == "reflex":
        # What is taken out lowers the pair too: five periods of a discharge of 1 mA for 0.2 s, 0.6 s after their start.
        ends = np.arange(5) + 0.8
        above -= 0.1 * 1e-3 * np.sum(np.exp(-(5.0 - ends) / 7.0) - np.exp(-(5.2 - ends) / 7.0))
    own = WAVEFORMS[waveform](0.5, 2 * (2.0 + above))
    own |= {"frequency_hz": 1.0} if waveform in ("pulse", "reflex") else {}
    own |= {"discharge_a": 1e-3} if waveform == "reflex" else {}
    phases = {
        "begin": {"constant_current": {"current_a": 0.5}, "until": {"elapsed_s": 20.0}},
        "low": {waveform: own, "limit": {"voltage_v": 2 * (2.0 + above)}},
    }
    window = [{"start_s": 20.0, "length_s": 9.0}]
    mode = Mode(title=waveform, phases=phases, stop={"elapsed_s": 30.0})
    wave = charge(cell, mode, settings(0.1, windows=window)).waveform
    time, current = wave["time_s"], wave["current_a"]
    first = int(np.argmax((current > 0.0) & (time > 20.0)))
    # A thousand-millionth of the voltage below the limit, so that nothing chatters.
    assert time[first - 1] == pytest.approx(25.0, abs=1e-6)
    assert np.max(current[(time > 20.0) & (time < 25.0 - 1e-6)]) <= 0.0


def test_nor_over_a_day_of_clouds():
    """14.4 V, then 13.2 V, its sun coming and going: no current but into the battery."""
    phases = {
        "bulk": {"constant_voltage": {"voltage_v": 14.4, "max_current_a": 2.1}, "until": {"current_a": 0.35}},
        "float": {"constant_voltage": {"voltage_v": 13.2, "max_current_a": 2.1}},
    }
    mode = Mode(title="float", phases=phases, stop={"elapsed_s": 40000})
    clouds = sun([40.0] * 18 + [0.0, 40.0, 5.0] * 6 + [40.0] * 12, interval_s=600.0)
    conditions = DayConditions(
        initial_soc=0.8, switching=Switching(start_power_w=2.0, stop_power_w=1.0), sample_interval_s=5.0
    )
    found = charge_over_day(battery("lead_acid_12v7ah"), mode, clouds, conditions, EngineSettings())
    assert found.charge_out_ah < 1e-14
    assert np.min(found.trace["current_min_a"]) > -1e-12
    trace = found.trace
    floats = np.arange(len(trace["soc"])) > np.argmax(trace["current_min_a"] < 0.35)
    blocked = floats & (trace["voltage_min_v"] > 13.2 + 1e-6)
    assert np.sum(blocked) > 3
    assert np.max(trace["current_max_a"][blocked]) < 1e-11  # rounding
    assert np.max(trace["current_max_a"][floats]) > 0.02
