"""Clouds: the same day every time, and over many days the shares they are asked for."""

import numpy as np
import pytest

from pipeline.weather.clear_sky import transmittance
from pipeline.weather.records import Clouds

CLOUDS = Clouds(sun_share=0.5, mean_cloud_s=600.0, transmittance=0.33, spread=0.4, seed=7)
LONG = np.arange(30.0, 400 * 86400.0, 60.0)


def test_the_seed_decides_the_day():
    one, again = transmittance(CLOUDS, LONG[:1440]), transmittance(CLOUDS, LONG[:1440])
    other = transmittance(CLOUDS.model_copy(update={"seed": 8}), LONG[:1440])
    np.testing.assert_array_equal(one, again)
    assert (one != other).any()


def test_a_finer_look_sees_the_same_clouds():
    coarse = transmittance(CLOUDS, LONG[:1440])
    fine = transmittance(CLOUDS, np.arange(30.0, 86400.0, 20.0))
    np.testing.assert_array_equal(fine[::3], coarse)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_the_sun_has_its_share(share):
    found = transmittance(CLOUDS.model_copy(update={"sun_share": share}), LONG)
    assert np.mean(found == 1.0) == pytest.approx(share, abs=0.01)


def test_clouds_are_as_long_and_as_dark_as_asked():
    found = transmittance(CLOUDS, LONG)
    cloudy = found < 1.0
    begins = np.count_nonzero(cloudy[1:] & ~cloudy[:-1])
    # Looked at once a minute, two-state chain of rates 1/600 s: the share cloudy over the rate of beginnings seen.
    seen_s = 60.0 * 0.5 / (0.25 * -np.expm1(-2.0 * 60.0 / 600.0))
    assert 60.0 * np.count_nonzero(cloudy) / begins == pytest.approx(seen_s, rel=0.02)
    assert found[cloudy].mean() == pytest.approx(0.33, rel=0.02)
    assert found[cloudy].min() >= 0.33 * 0.6
    assert found[cloudy].max() <= 0.33 * 1.4


def test_without_sun_one_cloud_follows_another():
    found = transmittance(CLOUDS.model_copy(update={"sun_share": 0.0}), LONG[:14400])
    assert (found < 1.0).all()
    assert len(np.unique(found)) > 100


def test_an_edge_passes_evenly_and_ends_where_the_cloud_stands():
    """Between the edges all is as without them; within one the share goes straight from one side to the other."""
    times = np.arange(0.0, 86400.0, 0.5)
    sharp, soft = (transmittance(CLOUDS.model_copy(update={"edge_s": edge}), times) for edge in (0.0, 8.0))
    begins = np.flatnonzero(np.diff(sharp) != 0.0)
    apart = (np.diff(begins, prepend=-100) > 20) & (np.diff(begins, append=begins[-1] + 100) > 20)
    assert np.count_nonzero(apart) > 50
    for row in begins[apart]:
        np.testing.assert_array_equal(soft[row + 18 : row + 20], sharp[row + 18 : row + 20])
        steps = np.diff(soft[row + 2 : row + 16])
        np.testing.assert_allclose(steps, (sharp[row + 18] - sharp[row]) / 16.0, rtol=1e-6)
    away = np.ones(len(times), dtype=bool)
    for row in begins:
        away[row : row + 19] = False
    np.testing.assert_array_equal(soft[away], sharp[away])
