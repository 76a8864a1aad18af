"""The switched converters, one under its control, against solve_ivp: Kirchhoff's laws anew, events for zero current."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.converter.switched import gains, run_boost, run_buck, start
from pipeline.converter.topologies import PanelSource
from tests.converter.switched_samples import BATTERY, BUS_V, boost_stage, buck_stage, pulses

RESISTOR_OHM = 27.0
SAMPLES = 4


def node_v(stage, z, isolated):
    if isolated:
        return z[1] + stage.capacitor_resistance_ohm * z[0]
    own, battery = 1 / stage.capacitor_resistance_ohm, 1 / BATTERY.series_resistance_ohm
    return (own * z[1] + battery * (BATTERY.voltage_v + z[2]) + z[0]) / (own + battery)


def slopes(stage, switch, z):
    """Return dz/dt for inductor current, capacitor voltage, pair voltage and the integral of the first and of v."""
    current, capacitor, pair = z[:3]
    node = node_v(stage, z, switch == "discharge")
    battery_a = (node - BATTERY.voltage_v - pair) / BATTERY.series_resistance_ohm
    if switch == "discharge":
        battery_a = -(BATTERY.voltage_v + pair) / (RESISTOR_OHM + BATTERY.series_resistance_ohm)
    driving = {
        "on": BUS_V - stage.on_resistance_ohm * current,
        "low": -stage.rectifier_resistance_ohm * current,
        "diode": -stage.rectifier_voltage_v - stage.rectifier_resistance_ohm * current,
        "return": BUS_V + stage.rectifier_voltage_v - stage.on_resistance_ohm * current,
    }.get(switch)
    rise = 0.0 if driving is None else (driving - stage.inductor_resistance_ohm * current - node) / stage.inductance_h
    into_capacitor = (node - capacitor) / stage.capacitor_resistance_ohm
    pair_rise = battery_a / (BATTERY.pair_time_constant_s / BATTERY.pair_resistance_ohm)
    terminal = BATTERY.voltage_v + pair + BATTERY.series_resistance_ohm * battery_a
    return [
        rise,
        into_capacitor / stage.capacitance_f,
        pair_rise - pair / BATTERY.pair_time_constant_s,
        current,
        terminal,
    ]


def empty(time, z):
    return z[0]


empty.terminal = True


def run_independently(stage, reference):
    state, memory = start(stage, BUS_V, BATTERY, reference[0], 0.02)
    control, period = gains(stage, BUS_V), stage.switching_period_s
    z, integral, mean, terminal = np.array([*state[:3], 0.0, 0.0]), *memory
    rows = []
    for asked in reference:
        duty = 0.0
        if asked > 0:
            error = asked - mean
            moved = integral + control.integral_per_a * error
            wanted = terminal / BUS_V + control.proportional_per_a * error + moved
            duty = min(max(wanted, 0.0), control.most_duty)
            integral = moved if duty == wanted or (duty - wanted) * error > 0 else integral
        z[3:] = 0.0
        idle = "discharge" if asked < 0 else "blocked"
        time, switch = 0.0, "on"
        grid = period / SAMPLES * np.arange(SAMPLES)
        while time < period:
            if switch == "on" and time >= duty * period:
                switch = "low" if asked > 0 and stage.rectifier == "synchronous" else "diode"
                if switch == "diode" and z[0] <= 0:
                    switch = idle if z[0] == 0 else "return"
            end = duty * period if switch == "on" else period
            events = empty if switch in ("diode", "return") else None
            if events is not None:
                empty.direction = -1.0 if switch == "diode" else 1.0
            found = solve_ivp(
                lambda _, z, switch=switch: slopes(stage, switch, z), (time, end), z, method="DOP853", rtol=1e-12,
                atol=1e-13, events=events, dense_output=True,
            )  # fmt: skip
            reached = found.t[-1]
            rows += [found.sol(at)[0] for at in grid[(grid >= time) & (grid < reached)]]
            z, time = found.y[:, -1].copy(), reached
            if found.status == 1:
                z[0], switch = 0.0, idle
        mean, terminal = z[3] / period, z[4] / period
    return np.array(rows)


@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
def test_samples_agree(rectifier):
    stage = buck_stage(rectifier=rectifier)
    reference = pulses()
    found = run_buck(stage, BUS_V, BATTERY, reference, 0.02, SAMPLES, RESISTOR_OHM)
    peer = run_independently(stage, reference)
    np.testing.assert_allclose(found.samples[0][:-1], peer, rtol=0, atol=2e-9)
    assert (found.samples[0].min() < -0.05) == (rectifier == "synchronous")


PANEL = PanelSource(34.8, 4.64)


def boost_slopes(stage, switch, bus_ohm, z):
    """Return dz/dt for inductor current, capacitor voltage and panel voltage."""
    current, capacitor, panel = z
    passed = current if switch in ("low", "diode") else 0.0
    # Bus and capacitor are one node behind the capacitor's resistance.
    bus = (capacitor / stage.capacitor_resistance_ohm + passed) / (1 / stage.capacitor_resistance_ohm + 1 / bus_ohm)
    against = {
        "on": stage.on_resistance_ohm * current,
        "low": bus + stage.rectifier_resistance_ohm * current,
        "diode": bus + stage.rectifier_voltage_v + stage.rectifier_resistance_ohm * current,
    }.get(switch)
    rise = 0.0 if against is None else (panel - stage.inductor_resistance_ohm * current - against) / stage.inductance_h
    drawn = current if against is not None else 0.0
    return [
        rise,
        (passed - bus / bus_ohm) / stage.capacitance_f,
        ((PANEL.voltage_v - panel) / PANEL.resistance_ohm - drawn) / stage.input_capacitance_f,
    ]


def run_boost_independently(stage, bus_ohm, duty, z, periods):
    period, rows = stage.switching_period_s, []
    empty.direction = -1.0
    off = "low" if stage.rectifier == "synchronous" else "diode"
    for _ in range(periods):
        grid = period / SAMPLES * np.arange(SAMPLES)
        time, switch = 0.0, "on"
        while time < period:
            end = duty * period if switch == "on" else period
            found = solve_ivp(
                lambda _, z, switch=switch: boost_slopes(stage, switch, bus_ohm, z), (time, end), z, method="DOP853",
                rtol=1e-12, atol=1e-13, events=empty if switch == "diode" else None, dense_output=True,
            )  # fmt: skip
            rows += [found.sol(at)[0] for at in grid[(grid >= time) & (grid < found.t[-1])]]
            z, time = found.y[:, -1].copy(), found.t[-1]
            switch = off
            if found.status == 1:
                z[0], switch = 0.0, "blocked"
    return np.array(rows)


@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
@pytest.mark.parametrize("bus_ohm", [30.0, 2000.0])
def test_samples_of_the_boost_agree(rectifier, bus_ohm):
    stage = boost_stage(rectifier=rectifier)
    begin = np.array([0.2, 36.0, 17.4])
    found = run_boost(stage, PANEL, bus_ohm, 0.3, begin, 60, SAMPLES)
    peer = run_boost_independently(stage, bus_ohm, 0.3, begin, 60)
    np.testing.assert_allclose(found.samples[0][:-1], peer, rtol=0, atol=2e-9)
    runs_empty = bool((found.samples[0] == 0.0).any())
    assert runs_empty == (rectifier == "diode_emulated")
