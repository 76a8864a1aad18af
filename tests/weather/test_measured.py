"""Measured and constant weather as columns; gaps are dark and told."""

import numpy as np
import pytest

from pipeline.panel.records import ConstantWeather
from pipeline.weather.measured import gaps
from pipeline.weather.records import MeasuredWeather, NoctCells
from pipeline.weather.sky import Measured, sky_of
from pipeline.weather.summary import quantities

CARD = MeasuredWeather(
    title="own", file="own.csv", longest_gap_s=600.0, wind_m_s=1.0, cell_temperature=NoctCells(noct_c=45.0)
)
CLOCK = 6 * 3600 + np.array([0.0, 300.0, 600.0, 3000.0, 3300.0])
ROWS = Measured(CLOCK, np.array([100.0, 200.0, 300.0, 400.0, -2.0]), np.array([10.0, 11.0, 12.0, 13.0, 14.0]))


def test_what_no_row_holds_for_is_dark():
    found = sky_of(CARD, 0.0, ROWS)
    np.testing.assert_array_equal(found.time_s, [0, 300, 600, 1200, 3000, 3300])
    np.testing.assert_array_equal(found.irradiance_w_m2, [100, 200, 300, 0, 400, 0])
    np.testing.assert_array_equal(found.ambient_c, [10, 11, 12, 12, 13, 14])
    assert (found.clock_s, found.end_s) == (6 * 3600.0, 3600.0)


def test_gaps_are_told():
    missing = gaps(ROWS, 600.0)
    assert [(gap.start_s, gap.length_s) for gap in missing] == [(6 * 3600 + 1200.0, 1800.0)]
    sky = sky_of(CARD, 0.0, ROWS)
    columns = {name: getattr(sky, name) for name in ("time_s", "irradiance_w_m2", "ambient_c", "cell_temperature_c")}
    columns["interval_s"] = np.diff(sky.time_s, append=sky.end_s)
    found = {one.name: one.value for one in quantities(CARD, columns, ROWS)}
    assert (found["gaps"], found["gap_s"], found["length_s"]) == (1, 1800, 3600)
    assert found["irradiation_kwh_m2"] == pytest.approx((100 * 300 + 200 * 300 + 300 * 600 + 400 * 300) / 3.6e6)


def test_its_own_wind_cools_the_cells():
    from pipeline.weather.records import FaimanCells

    card = CARD.model_copy(update={"cell_temperature": FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=7.0)})
    windy = sky_of(card, 0.0, ROWS._replace(wind_m_s=np.full(5, 8.0)))
    assert (windy.cell_temperature_c <= sky_of(card, 0.0, ROWS).cell_temperature_c).all()
    assert windy.cell_temperature_c[4] < sky_of(card, 0.0, ROWS).cell_temperature_c[4] - 1.0


def test_constant_weather_has_one_row_and_no_end():
    card = ConstantWeather(title="constant", irradiance_w_m2=800.0, cell_temperature_c=40.0)
    found = sky_of(card, 21.0)
    assert [column.tolist() for column in found[:4]] == [[0.0], [800.0], [21.0], [40.0]]
    assert found.end_s == np.inf
