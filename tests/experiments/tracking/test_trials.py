"""The trials of the trackers: ramps, days, steady light, and the numbers that they come to."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.experiments.tracking.records import TRACKING_NUMBERS
from pipeline.experiments.tracking.shading import settling, steady, summary
from pipeline.experiments.tracking.tracking import captured, profile
from pipeline.tracker.loop import available
from pipeline.weather.clear_sky import sky_of
from tests.tracker.conftest import NAMES, tracker


def test_a_ramp_goes_up_and_down_as_often_as_asked(tracking):
    ramps = tracking.ramps["low_to_medium"]
    time, light, counts = profile(ramps, 50.0, 3)
    assert time[counts][0] == pytest.approx(0.0, abs=1e-9)
    assert light.min() == ramps.low_w_m2
    assert light.max() == ramps.high_w_m2
    assert counts.sum() * 0.05 == pytest.approx(3 * 2 * (400.0 / 50.0 + ramps.dwell_s), abs=0.06)
    assert light[counts].mean() == pytest.approx(300.0, rel=1e-3)


def test_days_are_those_of_the_weather(source, tracking):
    skies = {name: sky.model_copy(update={"interval_s": 20.0}) for name, sky in tracking.skies.items()}
    found = captured(source, {name: tracker(name) for name in ("variable_step", "constant_voltage")}, skies)
    assert found["sky"] == ["clear", "clear", "broken", "broken"]
    for place, name in ((0, "clear"), (2, "broken")):
        sky = sky_of(skies[name], 0.0)
        whole = available(source, sky.irradiance_w_m2, sky.cell_temperature_c).sum() * 20.0 / 3600.0
        assert found["available_wh"][place] == found["available_wh"][place + 1] == pytest.approx(whole, rel=1e-12)
    assert 0.5 < found["available_wh"][2] / found["available_wh"][0] < 0.9
    assert min(found["efficiency"][::2]) > 0.98
    np.testing.assert_allclose(found["efficiency"], np.divide(found["captured_wh"], found["available_wh"]))
    assert max(found["efficiency"]) < 1.0


def test_settling_counts_to_the_last_time_outside():
    power = np.array([0.0, 5.0, 9.5, 10.2, 9.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0])
    assert settling(power, 0.5, 0.02) == 2.5
    assert settling(np.full(9, 3.0), 0.5, 0.02) == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_numbers_of_steady_light(source, tracking, name):
    found = {one.name.removeprefix(f"{name}_"): one.value for one in steady(source, name, tracker(name), tracking)}
    assert found["steady_efficiency"] >= 0.995
    assert 0.0 <= found["ripple_v"] < 0.5
    assert found["start_s"] < 40.0


def test_the_vocabulary_covers_the_numbers(source, tracking):
    tried = {name: tracker(name) for name in ("perturb_observe", "particle_swarm")}
    ramps = {"tracker": [name for name in tried for _ in "ab"], "efficiency": [0.9, 0.8, 0.99, 0.97]}
    found = summary(source, tried, tracking, ramps)
    assert {one.name for one in found} == TRACKING_NUMBERS.names({"tracker": tried})
    assert {one.name: one.value for one in found}["particle_swarm_worst_ramp"] == 0.97
