"""Maximum power over arrays of conditions: against pvlib, against what it must satisfy, at the ends."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import calcparams_cec, max_power_point, singlediode

from pipeline.errors import UserError
from pipeline.panel.maximum_power import Conditions, characteristic_points, maximum_of, maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, fit


@pytest.fixture(scope="module")
def diode(kc65t: Panel) -> SingleDiode:
    return fit(kc65t)


def weather(count: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    irradiance = np.concatenate([10 ** rng.uniform(-2, 3, count // 2), rng.uniform(0.1, 2000.0, count // 2)])
    return irradiance, rng.uniform(-60.0, 120.0, count)


def of_pvlib(panel: Panel, diode: SingleDiode, irradiance, temperature):
    return calcparams_cec(
        irradiance, temperature, panel.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
        diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm, diode.adjust_percent,
    )  # fmt: skip


def test_it_agrees_with_pvlib(kc65t, diode):
    irradiance, temperature = weather()
    found = characteristic_points(kc65t, diode, irradiance, temperature)
    peer = singlediode(*of_pvlib(kc65t, diode, irradiance, temperature), method="newton")
    bright = irradiance > 1.0  # below, pvlib's own points are less exact than what is asked
    for ours, theirs in zip(found, ("i_mp", "v_mp", "p_mp", "i_sc", "v_oc"), strict=True):
        np.testing.assert_allclose(ours[bright], np.asarray(peer[theirs])[bright], rtol=1e-10)
    only = maximum_power(kc65t, diode, irradiance, temperature)
    np.testing.assert_array_equal(only.max_power_w, found.max_power_w)


@pytest.mark.parametrize("series_ohm", [0.0, 0.3, 3.0, 40.0])
@pytest.mark.parametrize("shunt_ohm", [4.0, 100.0, 1e9])
def test_odd_panels_too(series_ohm, shunt_ohm):
    """Series and shunt resistances far from a panel's, which the first steps do not settle."""
    photo = np.geomspace(1e-3, 8.0, 40)
    found = maximum_of(Conditions(photo, np.full(40, 1e-9), np.full(40, 1 / shunt_ohm), np.full(40, 1.2)), series_ohm)
    peer = max_power_point(photo, 1e-9, series_ohm, shunt_ohm, 1.2, method="brentq")
    np.testing.assert_allclose(found.max_power_w, peer["p_mp"], rtol=1e-10)


def test_dark_gives_nothing_and_shapes_are_kept(kc65t, diode):
    found = characteristic_points(kc65t, diode, [[0.0, 500.0], [1000.0, 0.0]], 25.0)
    for part in found:
        assert part.shape == (2, 2)
        assert part[0, 0] == part[1, 1] == 0.0
        assert part[1, 0] > 0.0
    assert found.max_power_w[1, 0] == pytest.approx(17.4 * 3.75, rel=1e-9)


def test_more_light_gives_more_and_warmth_less(kc65t, diode):
    light = maximum_power(kc65t, diode, np.linspace(1, 1500, 400), 25.0).max_power_w
    warmth = maximum_power(kc65t, diode, 800.0, np.linspace(-20, 90, 400)).max_power_w
    assert np.all(np.diff(light) > 0)
    assert np.all(np.diff(warmth) < 0)


@pytest.mark.parametrize(
    ("irradiance", "temperature", "message"),
    [(-1.0, 25.0, "irradiance_w_m2: value -1"), (np.nan, 25.0, "irradiance"), (1.0, -300.0, "cell_temperature_c")],
)
def test_what_cannot_be_is_refused(kc65t, diode, irradiance, temperature, message):
    with pytest.raises(UserError, match=message):
        maximum_power(kc65t, diode, [irradiance, 5.0], temperature)
