"""Strings in partial shadow: the curve against pvlib, its maxima, and which tracker finds the highest."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import i_from_v
from pvlib.singlediode import bishop88_v_from_i

from pipeline.experiments.tracking.shading import curve, ends
from pipeline.tracker.source import available_power_w, of_all_panels
from tests.tracker.conftest import tracker

CAUGHT = ("perturb_observe", "incremental_conductance", "variable_step", "constant_voltage")


def maxima(found):
    power = found.voltage_v * found.current_a
    inner = (power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:])
    return found.voltage_v[1:-1][inner], power[1:-1][inner]


@pytest.mark.parametrize("groups", [1, 2, 3])
def test_even_light_gives_the_curve_of_the_panel(source, groups):
    found = curve(source, [800.0] * groups, 25.0, 0.5)
    (photo, saturation, shunt, ideality), series = of_all_panels(source, [800.0], 25.0)
    voltage = found.voltage_v[:-1:100]
    expected = i_from_v(voltage, photo[0], saturation[0], series, 1 / shunt[0], ideality[0])
    np.testing.assert_allclose(found.current_a[:-1:100], expected, atol=2e-5)
    best = (found.voltage_v * found.current_a).max()
    assert best == pytest.approx(available_power_w(source, 800.0, 25.0)[0], rel=1e-6)


@pytest.mark.parametrize("levels", [(1000.0, 400.0), (1000.0, 700.0, 200.0), (900.0, 899.0)])
def test_uneven_light_gives_the_voltages_of_bishops_model(source, levels):
    found = curve(source, levels, 35.0, 0.6)
    parameters, series = of_all_panels(source, np.array(levels), 35.0)
    count = len(levels)
    current = np.linspace(0.01, 0.999 * parameters[0].max(), 200)
    total = np.zeros_like(current)
    for photo, saturation, shunt, ideality in parameters.T:
        for place, one in enumerate(current):
            group = -np.inf
            if one < photo * 0.9999:
                group = bishop88_v_from_i(
                    one, photo, saturation, series / count, 1 / (shunt * count), ideality / count, method="brentq"
                )
            total[place] += max(float(group), -0.6)
    kept = total > 0.0
    ours = np.interp(total[kept], found.voltage_v, found.current_a)
    np.testing.assert_allclose(ours, current[kept], rtol=1e-3, atol=1e-3)


def test_the_current_falls_and_a_shadow_makes_two_maxima(source):
    found = curve(source, [1000.0, 400.0], 25.0, 0.5)
    assert np.all(np.diff(found.current_a) <= 1e-12)
    where, power = maxima(found)
    assert len(where) == 2
    assert power[0] > power[1]
    assert where[0] < 10.0 < where[1]


def test_a_better_bypass_diode_leaves_more(source):
    best = [
        (found.voltage_v * found.current_a).max() for found in (curve(source, [1000, 300], 25.0, v) for v in (0.2, 0.7))
    ]
    assert best[0] > best[1]


def test_trackers_are_caught_on_a_local_maximum_and_the_swarm_is_not(source, tracking):
    names = (*CAUGHT, "particle_swarm")
    trackers = {name: tracker(name) for name in names}
    _, found = ends(source, trackers, tracking.shading, 25.0)
    share = {(s, n): value for s, n, value in zip(found["scene"], found["tracker"], found["share"], strict=True)}
    for name in CAUGHT:
        assert share["half_shadow", name] < 0.95
        assert share["deep_shadow", name] < 0.40
        assert share["light_shadow", name] > 0.95
    for scene in tracking.shading.scenes:
        assert share[scene, "particle_swarm"] > 0.99
    assert max(share.values()) <= 1.0 + 1e-6
