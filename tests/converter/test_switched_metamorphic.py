"""What must not change, or must change in proportion, when the same converter is described otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.converter.switched import follow, gains, run_buck, start
from pipeline.converter.topologies import BatteryLoad, buck, maps
from tests.converter.switched_samples import BATTERY, BUS_V, buck_stage, pulses


def test_more_samples_change_nothing():
    coarse = run_buck(buck_stage(), BUS_V, BATTERY, pulses(), 0.01, 10, 27.0)
    fine = run_buck(buck_stage(), BUS_V, BATTERY, pulses(), 0.01, 40, 27.0)
    np.testing.assert_allclose(fine.samples[:, ::4], coarse.samples, rtol=0, atol=1e-10)


def test_impedances_scaled_scale_the_currents():
    k = 7.0
    stage = buck_stage()
    names = ("on_resistance_ohm", "rectifier_resistance_ohm", "inductance_h", "inductor_resistance_ohm")
    scaled = {name: k * getattr(stage, name) for name in (*names, "capacitor_resistance_ohm")}
    battery = BatteryLoad(BATTERY.voltage_v, k * BATTERY.series_resistance_ohm, k * BATTERY.pair_resistance_ohm, 0.006)
    before = run_buck(stage, BUS_V, BATTERY, pulses(), 0.01, 20, 27.0)
    other = buck_stage(capacitance_f=stage.capacitance_f / k, **scaled)
    after = run_buck(other, BUS_V, battery, pulses() / k, 0.01, 20, k * 27.0)
    np.testing.assert_allclose(after.periods["duty"], before.periods["duty"], atol=1e-10)
    np.testing.assert_allclose(k * after.samples[:2], before.samples[:2], atol=1e-9)


@pytest.mark.parametrize("rectifier", ["synchronous", "diode_emulated"])
def test_a_run_in_two_parts_is_the_run(rectifier):
    stage = buck_stage(rectifier=rectifier)
    made, control = maps(buck(stage, BUS_V, BATTERY, 27.0), 2e-5, 20), gains(stage, BUS_V)
    whole = follow(made, control, rectifier == "synchronous", pulses(), *start(stage, BUS_V, BATTERY, 2.1, 0.0))
    carried = start(stage, BUS_V, BATTERY, 2.1, 0.0)
    parts = [follow(made, control, rectifier == "synchronous", part, *carried) for part in np.split(pulses(), [47])]
    joined = np.concatenate([part.periods["battery_mean_a"] for part in parts])
    np.testing.assert_array_equal(joined, whole.periods["battery_mean_a"])


def test_a_diode_carries_nothing_back():
    run = run_buck(buck_stage(), BUS_V, BATTERY, pulses(), 0.0, 20, 27.0)
    assert run.samples[0].min() == 0.0


def test_without_a_switch_between_the_capacitor_follows_the_battery():
    """Left connected, the capacitor has nothing to give back when the discharge ends."""
    parted = run_buck(buck_stage(), BUS_V, BATTERY, pulses(), 0.0, 20, 27.0).periods["battery_max_a"][50:60]
    joined = run_buck(buck_stage(isolates_discharge=False), BUS_V, BATTERY, pulses(), 0.0, 20, 27.0)
    assert parted.max() > 0.1
    assert joined.periods["battery_max_a"][51:60].max() < 0.1 * parted.max()
