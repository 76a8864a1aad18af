"""Loads of one's own: power and energy, profiles by hour, weekday and month."""

import datetime

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.bus.load import drawn
from pipeline.bus.records import MeasuredLoad, ProfileLoad
from pipeline.errors import UserError
from pipeline.files.load import load_rows, told

SATURDAY, MONDAY = datetime.date(2015, 6, 20), datetime.date(2015, 6, 22)


def card(folder, text, **more):
    path = folder / "load.csv"
    path.write_text(text, encoding="utf-8")
    return MeasuredLoad(title="own", file=str(path), **more)


def test_energy_in_each_interval_is_power(tmp_path):
    rows = "".join(f"2015-06-20 {hour:02d}:{minute:02d};0,5\n" for hour in range(24) for minute in (0, 15, 30, 45))
    load = card(tmp_path, "Zeit;Verbrauch (kWh)\n" + rows)
    found = load_rows(load, SATURDAY)
    np.testing.assert_allclose(found.power_w, 2000.0)
    assert "'Verbrauch (kWh)' is in kWh" in told(load, SATURDAY)


def test_a_heading_without_a_unit_is_asked_for(tmp_path):
    text = "time,consumption\n00:00,1.5\n12:00,2.5\n"
    with pytest.raises(
        UserError, match=r"'consumption' says no unit, .* 'day\.load\.units=\{power_w: W\}', or kW, Wh, kWh"
    ):
        load_rows(card(tmp_path, text), None, "day.load")
    assert load_rows(card(tmp_path, text, units={"power_w": "kW"}), None).power_w.tolist() == [1500.0, 2500.0]
    assert load_rows(card(tmp_path, text, units={"power_w": "Wh"}), None).power_w.tolist() == [0.125, 2.5 / 12.0]
    with pytest.raises(UserError, match=r"no column 'power_w' \[W\]; 'load\.columns=\{power_w: \"HEADING\"\}'"):
        load_rows(card(tmp_path, "time,lamp\n00:00,1\n"), None)


def test_ends_of_intervals_and_only_the_day(tmp_path):
    rows = [f"2015-06-{day} {hour:02d}:00,{hour}" for day in (19, 20, 21) for hour in range(1, 25)]
    rows[3] = "2015-06-19 04:00,broken"
    load = card(tmp_path, "time,power_w\n" + "\n".join(rows), label="end")
    found = load_rows(load, SATURDAY)
    assert found.clock_s.tolist() == [3600.0 * hour for hour in range(-1, 24)]
    assert found.power_w.tolist() == [24.0, *range(1, 25)]
    with pytest.raises(UserError, match=r"line 5, column power_w: value 'broken'; allowed is a number from 0"):
        load_rows(load, datetime.date(2015, 6, 19))


def test_a_profile_by_month_weekday_and_hour(tmp_path):
    """As batcontrol and BreOS write them: months from 1, weekdays from 0 for Monday, Wh in each hour."""
    rows = [
        f"{month},{weekday},{hour},{100 * month + 10 * weekday + hour}"
        for month in range(1, 13)
        for weekday in range(7)
        for hour in range(24)
    ]
    load = card(tmp_path, "month,weekday,hour,energy (Wh)\n" + "\n".join(rows))
    found = load_rows(load, SATURDAY)
    span = drawn(load, 0.0, 86400.0, found)
    np.testing.assert_allclose(span.power_w, [650.0 + hour for hour in range(24)])
    assert drawn(load, 86400.0, 90000.0, found).power_w.tolist() == [660.0]
    with pytest.raises(UserError, match=r"goes by month and weekday, and the weather has no date; date the weather"):
        load_rows(load, None)
    with pytest.raises(UserError, match=r"line 3: hour 0 of its day stands there twice"):
        load_rows(card(tmp_path, "weekday,hour,power_w\nmon,0,1\nMonday,0,2\n"), MONDAY)
    with pytest.raises(UserError, match=r"no row for Saturday in month 6"):
        load_rows(card(tmp_path, "weekday,hour,power_w\nmon,0,1\n"), SATURDAY)
    with pytest.raises(UserError, match=r"line 2, column hour: value '25'; allowed is an hour"):
        load_rows(card(tmp_path, "hour,power_w\n25,1\n"), SATURDAY)


@pytest.mark.parametrize("first", [0, 1])
def test_a_profile_of_a_day_needs_no_date(tmp_path, first):
    rows = "".join(f"{hour + first},{hour}\n" for hour in range(24))
    found = load_rows(card(tmp_path, "hour,power_w\n" + rows), None)
    assert found.repeats
    assert found.clock_s.tolist() == [3600.0 * hour for hour in range(24)]
    assert found.power_w.tolist() == list(range(24))


def test_profiles_in_the_configuration():
    week = {"hours": [{"from_h": 0, "power_w": 1}, {"from_h": 18, "power_w": 9}]}
    load = ProfileLoad(
        title="own", profiles=[{"weekdays": ["sat", "sun"], "hours": [{"from_h": 0, "power_w": 5}]}, week]
    )
    found = load_rows(load, SATURDAY)
    assert drawn(load, 0.0, 86400.0, found).power_w.tolist() == [5.0]
    assert drawn(load, 0.0, 86400.0, load_rows(load, MONDAY)).power_w.tolist() == [1.0, 9.0]
    assert drawn(load, 172800.0, 259200.0, found).power_w.tolist() == [1.0, 9.0]
    with pytest.raises(UserError, match="goes by month and weekday, and the weather has no date"):
        load_rows(load, None)
    with pytest.raises(ValidationError, match="profiles have none for a mon in month 1"):
        ProfileLoad(title="own", profiles=[{"weekdays": ["sat"], "hours": [{"from_h": 0, "power_w": 5}]}])
