"""The clear sky against pvlib's own way to it, and days that are none."""

import numpy as np
import pandas as pd
import pytest
from pvlib import irradiance
from pvlib.location import Location

from pipeline.errors import UserError
from pipeline.weather.clear_sky import sky_of
from tests.weather.samples import weather


def by_pvlib(card):
    """Return irradiance on the panel through pvlib's `Location`, in local time with a zone."""
    place = Location(card.place.latitude_deg, card.place.longitude_deg, "Etc/GMT-8", card.place.altitude_m)
    times = pd.date_range("2015-03-20 00:00:30", periods=1440, freq="60s", tz="Etc/GMT-8")
    sun = place.get_solarposition(times)
    sky = place.get_clearsky(times, model="ineichen", linke_turbidity=card.linke_turbidity)
    return irradiance.get_total_irradiance(
        card.surface.tilt_deg,
        card.surface.azimuth_deg,
        sun["apparent_zenith"],
        sun["azimuth"],
        sky["dni"],
        sky["ghi"],
        sky["dhi"],
        dni_extra=irradiance.get_extra_radiation(times),
        albedo=card.surface.albedo,
        model="haydavies",
    )["poa_global"].to_numpy()


@pytest.mark.filterwarnings("ignore:divide by zero:RuntimeWarning", "ignore:DatetimeIndex.dayofyear")
def test_it_is_pvlibs():
    card = weather("clear_taichung")
    found, theirs = sky_of(card, 0.0), by_pvlib(card)
    lit = np.flatnonzero(theirs > 0)
    assert found.clock_s == 60.0 * lit[0]
    assert found.end_s == 60.0 * len(lit)
    np.testing.assert_allclose(found.irradiance_w_m2, theirs[lit], rtol=1e-9)


def test_an_equinox_day_is_half_a_day_and_about_noon():
    found = sky_of(weather("clear_taichung"), 0.0)
    assert found.end_s == pytest.approx(12 * 3600, abs=600)
    brightest = found.clock_s + found.time_s[np.argmax(found.irradiance_w_m2)]
    # The equation of time puts noon 7.5 minutes late; 0.73 degrees east of the zone's meridian are 2.9 minutes early.
    assert brightest == pytest.approx(12 * 3600 + 60 * (7.5 - 4 * 0.73), abs=180)


def test_the_air_is_warmest_when_it_is_said_to_be():
    found = sky_of(weather("clear_taichung"), 0.0)
    assert found.ambient_c.max() == pytest.approx(25.0, abs=1e-3)
    assert found.clock_s + found.time_s[np.argmax(found.ambient_c)] == pytest.approx(14 * 3600, abs=60)


def test_a_sky_without_clouds_is_clear_and_clouds_only_darken():
    clear = sky_of(weather("clear_taichung"), 0.0)
    clouds = {"mean_cloud_s": 600.0, "transmittance": 0.33, "spread": 0.4, "seed": 1}
    none = sky_of(weather("clear_taichung", kind="cloudy_sky", clouds=clouds | {"sun_share": 1.0}), 0.0)
    np.testing.assert_array_equal(none.irradiance_w_m2, clear.irradiance_w_m2)
    some = sky_of(weather("half_cloudy_taichung"), 0.0)
    day = some.irradiance_w_m2[60:-60] / clear.irradiance_w_m2[60:-60]
    assert (day == 1.0).any()
    assert (day < 0.6).any()
    assert day.max() == 1.0


def test_a_polar_night_is_refused():
    place = {"latitude_deg": 80.0, "longitude_deg": 0.0, "altitude_m": 0.0, "utc_offset_h": 0.0}
    with pytest.raises(UserError, match=r"2015-12-21.*latitude_deg 80: the sun does not rise"):
        sky_of(weather("clear_taichung", place=place, date="2015-12-21"), 0.0)
