from __future__ import annotations

import pytest
from pydantic import ValidationError

from pipeline.panel.curves import conditions
from pipeline.panel.records import ConstantWeather, PanelCurveSettings


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"max_power_voltage_v": 21.7}, "max_power_voltage_v is 21.7 V; it must lie below open_circuit_voltage_v"),
        ({"max_power_current_a": 4.2}, "max_power_current_a is 4.2 A; it must lie below short_circuit_current_a"),
        ({"max_power_w": 80.0}, "is 65.25 W; the two may differ by 5 %"),
        ({"beta_voc_v_per_k": 0.08}, "less than 0"),
        ({"cells_in_series": 0}, "greater than or equal to 1"),
        ({"colour": "blue"}, "Extra inputs are not permitted"),
    ],
)
def test_impossible_data_sheets_are_refused(kc65t, change, message):
    with pytest.raises(ValidationError, match=message):
        type(kc65t)(**{**kc65t.model_dump(), **change})


def test_approximate_power_is_the_data_sheet_at_its_own_conditions(kc65t):
    assert kc65t.approximate_power_w(1000.0, 25.0) == pytest.approx(65.25, rel=1e-12)
    assert kc65t.approximate_power_w(500.0, 25.0) == pytest.approx(65.25 / 2, rel=1e-12)
    assert kc65t.approximate_power_w(1000.0, 50.0) == pytest.approx(57.174, rel=1e-3)


def test_panels_in_series_and_in_parallel_count(kc65t):
    several = kc65t.model_copy(update={"panels_in_series": 2, "panels_in_parallel": 3})
    assert several.approximate_power_w(1000.0, 25.0) == pytest.approx(6 * 65.25)
    assert several.string_voltage_v == pytest.approx(34.8)


def test_the_grid_must_increase():
    with pytest.raises(ValidationError, match=r"irradiances_w_m2 is \[600.0, 400.0\]; it must increase"):
        PanelCurveSettings(irradiances_w_m2=(600.0, 400.0))


def test_constant_weather_is_one_row():
    rows = conditions(ConstantWeather(title="dim", irradiance_w_m2=300.0, cell_temperature_c=31.0))
    assert [column.tolist() for column in rows] == [[0.0], [300.0], [31.0]]
