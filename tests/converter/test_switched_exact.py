"""The switched converter against what can be written down: ring-down, ripple, balances, discontinuous current."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.converter.steady import discontinuous_point, steady_state, trace
from pipeline.converter.switched import follow, gains, of_boost, operating_point, run_buck, start
from pipeline.converter.topologies import (
    BLOCKED,
    CAPACITOR,
    DIODE,
    INDUCTOR,
    LOW,
    ON,
    THIRD,
    BatteryLoad,
    PanelSource,
    Topologies,
    boost,
    buck,
    exponential,
    maps,
)
from tests.converter.switched_samples import BATTERY, BUS_V, boost_stage, buck_stage

LOSSLESS = {
    "on_resistance_ohm": 0.0,
    "rectifier_resistance_ohm": 0.0,
    "inductor_resistance_ohm": 0.0,
    "rectifier_voltage_v": 0.0,
}
PERIOD_S = 2e-5


def fixed(stage, load, duty, state, periods, samples=20):
    """Run the kernel at a fixed duty."""
    made = maps(buck(stage, BUS_V, load, 27.0), stage.switching_period_s, samples)
    kept = np.array(state, dtype=float)
    synchronous = stage.rectifier == "synchronous"
    return follow(made, gains(stage, BUS_V), synchronous, np.ones(periods), kept, np.zeros(3), duty), kept


def test_a_free_filter_rings_down_as_a_damped_oscillation():
    stage = buck_stage(rectifier="synchronous", inductor_resistance_ohm=0.05, **{
        name: value for name, value in LOSSLESS.items() if name != "inductor_resistance_ohm"
    })  # fmt: skip
    absent = BatteryLoad(0.0, 1e12, 1e-12, 1.0)
    found, _ = fixed(stage, absent, 0.0, [0.0, 10.0, 0.0, 1.0], 200)
    resistance = stage.inductor_resistance_ohm + stage.capacitor_resistance_ohm
    decay = resistance / (2.0 * stage.inductance_h)
    omega = np.sqrt(1.0 / (stage.inductance_h * stage.capacitance_f) - decay**2)
    time = PERIOD_S / 20 * np.arange(200 * 20 + 1)
    exact = -10.0 / (omega * stage.inductance_h) * np.exp(-decay * time) * np.sin(omega * time)
    np.testing.assert_allclose(found.samples[0], exact, rtol=0, atol=1e-10)


def test_the_ripple_is_volts_times_time_over_inductance():
    stage = buck_stage(rectifier="synchronous", capacitor_resistance_ohm=1.0, **LOSSLESS)
    stiff = BatteryLoad(13.2, 1e-7, 1e-9, 1.0)
    duty = 13.2 / BUS_V
    ripple = (BUS_V - 13.2) * duty * PERIOD_S / stage.inductance_h
    found, _ = fixed(stage, stiff, duty, [2.0 - ripple / 2, 13.2, 0.0, 1.0], 1)
    assert found.samples[0].max() - found.samples[0].min() == pytest.approx(ripple, rel=1e-6)
    assert found.periods["inductor_mean_a"][0] == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
@pytest.mark.parametrize("duty", [0.571, 0.58, 0.6])
def test_volts_and_charges_balance_in_the_periodic_state(rectifier, duty):
    stage = buck_stage(rectifier=rectifier)
    made = buck(stage, BUS_V, BATTERY, 27.0)
    found = steady_state(made, rectifier == "synchronous", duty, PERIOD_S)
    assert found.valley_a > 0
    run, after = fixed(stage, BATTERY, duty, found.state, 3)
    np.testing.assert_allclose(after, found.state, rtol=1e-11)
    means = {name: column[-1] for name, column in run.periods.items()}
    assert means["inductor_mean_a"] == pytest.approx(found.mean[INDUCTOR], rel=1e-11)
    assert means["battery_mean_a"] == pytest.approx(means["inductor_mean_a"], rel=1e-10)  # no charge stays in C
    on_a, all_a = means["source_mean_a"], means["inductor_mean_a"]
    diode_v = stage.rectifier_voltage_v if rectifier == "diode_emulated" else 0.0
    driven = duty * BUS_V - (1 - duty) * diode_v - stage.on_resistance_ohm * on_a
    driven -= stage.rectifier_resistance_ohm * (all_a - on_a) + stage.inductor_resistance_ohm * all_a
    assert driven == pytest.approx(means["voltage_mean_v"], rel=1e-11)  # no volt-seconds stay on L


@pytest.mark.parametrize("converter", ["buck", "boost"])
@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
def test_power_in_is_power_out_and_losses(converter, rectifier):
    """In the periodic state, by Gauss's rule on the exact currents, from Kirchhoff's laws written anew."""
    duty, synchronous = 0.6, rectifier == "synchronous"
    if converter == "buck":
        stage = buck_stage(rectifier=rectifier)
        made: Topologies = buck(stage, BUS_V, BATTERY, 27.0)
    else:
        stage, source, load_ohm = boost_stage(rectifier=rectifier), PanelSource(34.8, 4.64), 30.0
        made = boost(stage, source, load_ohm)
    off = LOW if synchronous else DIODE
    state = steady_state(made, synchronous, duty, PERIOD_S).state
    nodes, weights = np.polynomial.legendre.leggauss(12)
    balance = given = 0.0
    for place, length in ((ON, duty * PERIOD_S), (off, (1 - duty) * PERIOD_S)):
        for node, weight in zip(nodes, weights, strict=True):
            z = exponential(made.generators[place], 0.5 * (node + 1) * length)[0] @ state
            current, third = z[INDUCTOR], z[THIRD]
            out_a, out_v = made.outputs[place] @ z
            switch_w = stage.on_resistance_ohm * current**2
            if place != ON:
                switch_w = stage.rectifier_resistance_ohm * current**2
                switch_w += 0.0 if synchronous else stage.rectifier_voltage_v * current
            losses = switch_w + stage.inductor_resistance_ohm * current**2
            if converter == "buck":
                taken = BUS_V * current if place == ON else 0.0
                losses += stage.capacitor_resistance_ohm * (current - out_a) ** 2
                losses += BATTERY.series_resistance_ohm * out_a**2 + third**2 / BATTERY.pair_resistance_ohm
                out = BATTERY.voltage_v * out_a
            else:
                fed = (source.voltage_v - third) / source.resistance_ohm
                taken, out = third * fed, out_v**2 / load_ohm
                losses += stage.capacitor_resistance_ohm * (out_a - out_v / load_ohm) ** 2
            balance += 0.5 * weight * length * (taken - out - losses)
            given += 0.5 * weight * length * taken
        state = exponential(made.generators[place], length)[0] @ state
    assert given > 0
    assert abs(balance) < 1e-11 * given


def test_a_discontinuous_current_is_made_of_triangles():
    stage = buck_stage(capacitor_resistance_ohm=1.0, **(LOSSLESS | {"rectifier_voltage_v": 0.4}))
    stiff = BatteryLoad(13.2, 1e-8, 1e-9, 1.0)
    duty = 0.2
    found, _ = fixed(stage, stiff, duty, [0.0, 13.2, 0.0, 1.0], 4)
    peak = (BUS_V - 13.2) * duty * PERIOD_S / stage.inductance_h
    fall_s = peak * stage.inductance_h / 13.6
    mean = 0.5 * peak * (duty * PERIOD_S + fall_s) / PERIOD_S
    np.testing.assert_allclose(found.periods["inductor_mean_a"], mean, rtol=1e-7)
    np.testing.assert_allclose(found.periods["source_mean_a"], 0.5 * peak * duty, rtol=1e-7)
    time = np.arange(21) * PERIOD_S / 20
    falling = peak * (1 - (time - duty * PERIOD_S) / fall_s)
    exact = np.maximum(np.where(time < duty * PERIOD_S, peak * time / (duty * PERIOD_S), falling), 0.0)
    np.testing.assert_allclose(found.samples[0][:21], exact, atol=1e-8)


def test_a_trace_is_what_the_kernel_runs_through():
    stage = buck_stage(rectifier="synchronous")
    made = buck(stage, BUS_V, BATTERY, 27.0)
    state = np.array([1.0, 13.0, 0.01, 1.0])
    points = trace(made, True, 0.583, PERIOD_S, 20, state, 50)
    found, _ = fixed(stage, BATTERY, 0.583, state, 50)
    np.testing.assert_allclose(points[:, INDUCTOR], found.samples[0], rtol=0, atol=1e-11)


def test_the_control_holds_the_mean_current():
    run = run_buck(buck_stage(), BUS_V, BATTERY, np.full(3000, 1.7), 0.0)
    assert run.periods["inductor_mean_a"][-1] == pytest.approx(1.7, abs=1e-9)
    state, memory = start(buck_stage(), BUS_V, BATTERY, 1.7, 0.0)
    assert memory[1] == 1.7
    assert state[INDUCTOR] > 0


@pytest.mark.parametrize("power_w", [0.5, 2.0, 3.5])
def test_a_boost_current_that_ends_within_the_period(power_w):
    """The periodic state, from its start by an integrator that waits for the diode's current to end."""
    stage = boost_stage()
    source = PanelSource(34.8, 17.4**2 / power_w)
    duty, resistance, found = discontinuous_point(stage, BUS_V, source)
    made = boost(stage, source, resistance)

    def ended(_, z):
        return z[INDUCTOR]

    ended.terminal, ended.direction = True, -1.0
    at, state = 0.0, found.state
    assert state[INDUCTOR] == 0.0
    for topology, until in ((ON, duty * PERIOD_S), (DIODE, PERIOD_S), (BLOCKED, PERIOD_S)):
        events = ended if topology == DIODE else None
        run = solve_ivp(lambda _, z, g=made.generators[topology]: g @ z, (at, until), state, "DOP853", events=events,
                        rtol=1e-12, atol=1e-12)  # fmt: skip
        at, state = float(run.t[-1]), run.y[:, -1]
        if topology == DIODE:
            assert at < 0.99 * PERIOD_S
    np.testing.assert_allclose(state, found.state, rtol=1e-9, atol=1e-9)
    assert found.mean[THIRD] == pytest.approx(17.4, rel=1e-10)
    assert found.mean[CAPACITOR] == pytest.approx(BUS_V, rel=1e-10)
    assert found.mean[INDUCTOR] == pytest.approx(power_w / 17.4, rel=1e-9)  # no charge stays in the input capacitor


def test_a_continuous_current_has_no_state_that_ends_within_the_period():
    with pytest.raises(ArithmeticError, match=r"no discontinuous state at 60 W"):
        discontinuous_point(boost_stage(), BUS_V, PanelSource(34.8, 17.4**2 / 60.0))


@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
def test_the_boost_converter_works_the_panel_at_its_point(rectifier):
    stage = boost_stage(rectifier=rectifier)
    source = PanelSource(34.8, 17.4 / 3.75)
    duty, resistance = operating_point(stage, BUS_V, source)
    found = steady_state(boost(stage, source, resistance), rectifier == "synchronous", duty, PERIOD_S)
    assert found.mean[THIRD] == pytest.approx(17.4, rel=1e-10)
    assert found.mean[CAPACITOR] == pytest.approx(BUS_V, rel=1e-10)
    assert found.mean[INDUCTOR] == pytest.approx(3.75, rel=1e-10)  # no charge stays in the input capacitor
    numbers = {quantity.name: quantity.value for quantity in of_boost(stage, BUS_V, 17.4, 3.75, 400)}
    drop_v = 3.75 * (stage.on_resistance_ohm + stage.inductor_resistance_ohm)
    ripple = (17.4 - drop_v) * duty * PERIOD_S / stage.inductance_h
    assert numbers["boost_inductor_ripple_a"] == pytest.approx(ripple, rel=5e-3)
    assert 0.9 < numbers["boost_conduction_efficiency"] < 1.0
