"""The bus: its load over the clock, its powers, and when it lets the charger draw."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from pipeline.bus.flows import MODE_1, MODE_2, OFF, Change, available, charging_spans, closed, flows, state_at
from pipeline.bus.load import Drawn, drawn, held
from pipeline.bus.records import HourlyLoad, LoadProfile, MeasuredLoad, Switching
from pipeline.converter.records import Converter, Load, PowerChain
from pipeline.errors import UserError

CHAIN = PowerChain(
    title="chain",
    bus_voltage_v=24.0,
    tracker_efficiency=0.99,
    boost=Converter(efficiency=0.95),
    buck=Converter(efficiency=0.92),
)
HOURS = HourlyLoad(title="hours", hours=({"from_h": 0, "power_w": 3}, {"from_h": 8, "power_w": 6}))
SWITCHING = Switching(start_power_w=2.0, stop_power_w=1.0)


def test_hours_follow_the_clock_day_after_day():
    found = drawn(HOURS, 7 * 3600.0, 33 * 3600.0)
    np.testing.assert_array_equal(found.clock_s / 3600, [7, 8, 24, 32])
    np.testing.assert_array_equal(found.power_w, [3, 6, 3, 6])


def test_a_constant_load_is_one_row():
    found = drawn(Load(title="constant", power_w=4.0), 100.0, 1e6)
    assert (found.clock_s.tolist(), found.power_w.tolist()) == ([100.0], [4.0])


def test_a_files_rows_hold_until_the_next_and_after_the_last():
    rows = Drawn(np.array([-100.0, 200.0, 400.0]), np.array([4.0, 5.0, 7.0]))
    load = MeasuredLoad(title="own", file="own.csv")
    for span, times, powers in (
        ((0, 1000), [0, 200, 400], [4, 5, 7]),
        ((500, 9e4), [500], [7]),
        ((250, 300), [250], [5]),
    ):
        found = drawn(load, float(span[0]), float(span[1]), rows)
        assert (found.clock_s.tolist(), found.power_w.tolist()) == (times, powers)


def test_a_file_that_begins_after_the_weather_is_refused():
    rows, load = Drawn(np.array([28800.0]), np.array([5.0])), MeasuredLoad(title="own", file="own.csv")
    with pytest.raises(UserError, match=r"own\.csv: begins 28800 s after midnight, the weather at 21600 s"):
        drawn(load, 21600.0, 64800.0, rows)


def test_a_files_times_of_day_come_again():
    rows = Drawn(np.array([0.0, 28800.0]), np.array([3.0, 6.0]), repeats=True)
    found = drawn(MeasuredLoad(title="own", file="own.csv"), 7 * 3600.0, 33 * 3600.0, rows)
    expected = drawn(HOURS, 7 * 3600.0, 33 * 3600.0)
    np.testing.assert_array_equal(found.clock_s, expected.clock_s)
    np.testing.assert_array_equal(found.power_w, expected.power_w)


def test_held_is_the_row_that_has_begun():
    assert held([0.0, 10.0], [1.0, 2.0], [0.0, 9.9, 10.0, 99.0]).tolist() == [1, 1, 2, 2]


def test_kinds_of_load_are_told_apart():
    read = TypeAdapter(LoadProfile).validate_python
    assert isinstance(read({"title": "plain", "power_w": 1.0}), Load)
    assert isinstance(read({"kind": "hours", "title": "hours", "hours": [{"from_h": 0, "power_w": 1}]}), HourlyLoad)
    with pytest.raises(ValidationError, match="the first row must begin at 0"):
        read({"kind": "hours", "title": "hours", "hours": [{"from_h": 1, "power_w": 1}]})
    rows = [{"from_h": hour, "power_w": 1} for hour in (0, 8, 6)]
    with pytest.raises(ValidationError, match="from 8 h to 6 h"):
        read({"kind": "hours", "title": "hours", "hours": rows})


def test_the_load_is_served_first():
    could = available([50.0, 5.0, 0.0], [40.0, 4.0, 0.0], 10.0, CHAIN)
    np.testing.assert_allclose(could.bus_w, [38.0, 3.8, 0.0])
    np.testing.assert_allclose(could.served_w, [10.0, 3.8, 0.0])
    np.testing.assert_allclose(could.battery_w, [0.92 * 28.0, 0.0, 0.0])


powers = st.lists(st.floats(0, 1e3), min_size=1, max_size=8)


@given(powers, st.floats(0, 50), st.floats(0, 1), st.floats(0.1, 1))
def test_what_comes_in_goes_out(panel, load, taken, tracked):
    """Whatever share of its power the battery takes: nothing appears, nothing is lost, at every stage."""
    panel_w = np.array(panel)
    could = available(panel_w, tracked * panel_w, load, CHAIN)
    did = flows(taken * could.battery_w, 0.0, could, CHAIN)
    close = {"rtol": 1e-12, "atol": 1e-9}
    np.testing.assert_allclose(did.drawn_w + did.curtailed_w, could.tracked_w, **close)
    np.testing.assert_allclose(CHAIN.boost.efficiency * did.drawn_w, did.bus_w, **close)
    np.testing.assert_allclose(did.bus_w, could.served_w + did.buck_w, **close)
    np.testing.assert_allclose(CHAIN.buck.efficiency * did.buck_w, did.charge_w, **close)
    assert (did.curtailed_w >= -1e-9).all()
    if taken == 1.0:
        np.testing.assert_allclose(did.curtailed_w, np.zeros_like(panel_w), atol=1e-9)


def test_the_charger_draws_with_hysteresis():
    time_s = 60.0 * np.arange(8)
    power = np.array([0.0, 1.5, 2.0, 1.5, 1.0, 0.9, 1.5, 3.0])
    found = charging_spans(time_s, power, 480.0, SWITCHING)
    assert [tuple(span) for span in found] == [(120.0, 300.0), (420.0, 480.0)]
    assert charging_spans(time_s, np.zeros(8), 480.0, SWITCHING) == []


def test_thresholds_in_the_wrong_order_are_refused():
    with pytest.raises(ValidationError, match=r"stop_power_w is 3 W.*start_power_w, 2 W"):
        Switching(start_power_w=2.0, stop_power_w=3.0)


def test_switches_stand_as_the_paper_says():
    assert closed(MODE_1) == (1, 1, 0)
    assert closed(MODE_2, 0.9, 0.05) == (1, 0.9, 0.05)
    assert closed(OFF) == (0, 0, 0)


def test_the_state_holds_from_its_change_on():
    changes = [Change(10.0, OFF, MODE_1, "", closed(MODE_1), 0.0), Change(20.0, MODE_1, OFF, "", closed(OFF), 0.0)]
    assert state_at(changes, np.array([5.0, 10.0, 19.0, 20.0])) == [OFF, MODE_1, MODE_1, OFF]
