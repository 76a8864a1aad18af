"""Measured and constant weather as columns; gaps are interpolated or dark, and told."""

import numpy as np
import pytest

from pipeline.experiments.days.weather import quantities
from pipeline.panel.records import ConstantWeather
from pipeline.weather.clear_sky import Measured, sky_of
from pipeline.weather.measured import DARK, INTERPOLATED, gaps
from pipeline.weather.records import MeasuredWeather, NoctCells

CARD = MeasuredWeather(
    title="own", file="own.csv", longest_gap_s=600.0, wind_m_s=1.0, cell_temperature=NoctCells(noct_c=45.0)
)
# Every 300 s; one row is missing, then seven.
CLOCK = 6 * 3600 + np.array([0.0, 300.0, 900.0, 1200.0, 3600.0, 3900.0])
ROWS = Measured(CLOCK, np.array([100.0, 200.0, 300.0, 350.0, 400.0, -2.0]), np.array([10.0, 11, 13, 14, 22, 23]))


def test_short_gaps_are_interpolated_and_long_ones_dark():
    found = sky_of(CARD, 0.0, ROWS)
    np.testing.assert_array_equal(found.time_s, 300.0 * np.arange(14))
    np.testing.assert_allclose(found.irradiance_w_m2, [100, 200, 250, 300, 350, *([0] * 7), 400, 0])
    np.testing.assert_allclose(found.ambient_c, np.arange(10, 24))
    assert (found.clock_s, found.end_s) == (6 * 3600.0, 4200.0)


def test_the_longest_gap_decides():
    """The gap of seven rows is 2100 s long: a second less is not enough."""
    for longest_s, filled in ((2100.0, INTERPOLATED), (2099.0, DARK)):
        card = CARD.model_copy(update={"longest_gap_s": longest_s})
        assert [gap.filled for gap in gaps(ROWS, longest_s)] == [INTERPOLATED, filled]
        light = sky_of(card, 0.0, ROWS).irradiance_w_m2[5:12]
        expected = 350 + 50 * np.arange(1, 8) / 8 if filled == INTERPOLATED else np.zeros(7)
        np.testing.assert_allclose(light, expected)
    nothing = CARD.model_copy(update={"longest_gap_s": 0.0})
    assert sky_of(nothing, 0.0, ROWS).irradiance_w_m2[2] == 0.0


def test_rows_hold_for_their_usual_distance_however_long():
    """A file by the hour has no gap."""
    hourly = Measured(3600.0 * np.arange(6, 12), 100.0 * np.arange(6), np.full(6, 20.0))
    assert gaps(hourly, 600.0) == []
    found = sky_of(CARD, 0.0, hourly)
    np.testing.assert_array_equal(found.irradiance_w_m2, hourly.irradiance_w_m2)
    assert found.end_s == 6 * 3600.0


def test_gaps_are_told():
    assert gaps(ROWS, 600.0) == [(6 * 3600 + 600.0, 300.0, INTERPOLATED), (6 * 3600 + 1500.0, 2100.0, DARK)]
    sky = sky_of(CARD, 0.0, ROWS)
    columns = {name: getattr(sky, name) for name in ("time_s", "irradiance_w_m2", "ambient_c", "cell_temperature_c")}
    columns["interval_s"] = np.diff(sky.time_s, append=sky.end_s)
    found = {one.name: one.value for one in quantities(CARD, columns, ROWS)}
    assert (found["gaps"], found["gap_s"], found["length_s"]) == (2, 2400, 4200)
    assert (found["dark_gaps"], found["dark_gap_s"]) == (1, 2100)
    assert found["irradiation_kwh_m2"] == pytest.approx(300 * (100 + 200 + 250 + 300 + 350 + 400) / 3.6e6)


def test_its_own_wind_cools_the_cells():
    from pipeline.weather.records import FaimanCells

    card = CARD.model_copy(update={"cell_temperature": FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=7.0)})
    windy = sky_of(card, 0.0, ROWS._replace(wind_m_s=np.full(6, 8.0)))
    assert (windy.cell_temperature_c <= sky_of(card, 0.0, ROWS).cell_temperature_c).all()
    assert windy.cell_temperature_c[4] < sky_of(card, 0.0, ROWS).cell_temperature_c[4] - 1.0


def test_constant_weather_has_one_row_and_no_end():
    card = ConstantWeather(title="constant", irradiance_w_m2=800.0, cell_temperature_c=40.0)
    found = sky_of(card, 21.0)
    assert [column.tolist() for column in found[:4]] == [[0.0], [800.0], [21.0], [40.0]]
    assert found.end_s == np.inf
