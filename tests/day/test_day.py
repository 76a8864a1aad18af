"""A charge over a day: against the plain charge, against exact solutions, and its switchings where they belong."""

import numpy as np
import pytest

from pipeline.bus.flows import ENDED, MODE_1, MODE_2, OFF
from pipeline.charge.records import ChargeSettings, EngineSettings
from pipeline.charge.simulate import Supply, simulate
from pipeline.day.charge import charge_over_day, still_to_run
from tests.charge.samples import BATTERIES, MODES, SUITED, battery, suited_mode
from tests.day.samples import BATTERY, CONDITIONS, HOUR, day, mode, sun

PULSES = {
    "bulk": {"constant_voltage": {}, "until": {"elapsed_s": 1e-3}},
    "pulse": {"pulse": {}, "limit": {"voltage_v": "voltage_v"}},
}


def changes(found):
    return [(change.after, change.reason) for change in found.changes]


@pytest.mark.parametrize("power_w", [1e3, 20.0])
@pytest.mark.parametrize("name", ["cc_cv", "cv_pulse", "cv_reflex"])
def test_a_day_of_constant_sun_is_the_plain_charge(name, power_w):
    settings = ChargeSettings(initial_soc=0.6, ambient_c=25.0, sample_interval_s=60.0)
    supply = Supply(np.zeros(1), np.full(1, power_w))
    plain = simulate(BATTERY, mode(name), supply, settings, EngineSettings())
    found = day(name, sun([power_w], interval_s=6 * HOUR))
    rows = len(plain.trace["soc"])
    for column in ("Test Time / s", "soc", "Voltage / V", "Current / A", "Surface Temperature / degC"):
        np.testing.assert_array_equal(found.trace[column][:rows], plain.trace[column])
    summary = {one.quantity: one.value for one in plain.summary}
    assert found.changes[-1].after == ENDED
    assert found.changes[-1].time_s == summary["end_time_s"]
    assert found.voltage_limited_s == summary["time_at_voltage_limit_s"]
    assert found.supply_limited_s == summary["time_at_supply_limit_s"]


def test_sunshine_given_in_pieces_is_the_same_sunshine():
    one = day("cv_reflex", sun([20.0], interval_s=2 * HOUR))
    many = day("cv_reflex", sun([20.0] * 24, interval_s=300.0))
    assert many.end_soc == pytest.approx(one.end_soc, rel=1e-6)
    assert [change.time_s for change in many.changes] == pytest.approx([change.time_s for change in one.changes])


def test_a_pause_stops_the_clock_of_a_phase():
    """The sheet asks for an hour of bulk: 40 minutes before the cloud, 20 after it."""
    found = day("cv_reflex", sun([30.0] * 4 + [0.5] * 3 + [30.0] * 6))
    assert [change.after for change in found.changes] == [MODE_1, OFF, MODE_1, MODE_2]
    assert [change.time_s for change in found.changes] == pytest.approx([0.0, 2400.0, 4200.0, 5400.0], abs=1e-6)
    assert found.changes[3].reason == "elapsed 3600 s"
    assert found.changes[1].reason == "surplus below 1 W"


def test_what_a_day_did_not_bring_is_said():
    """Bulk lasts an hour: 40 minutes of sun do not see its end, and the pulses after it never begin."""
    short = day("cv_reflex", sun([30.0] * 4 + [0.0] * 6))
    assert short.missed == f"SOC 0.99 not reached by last light, SOC {short.end_soc:.4g}; reflex never ran"
    whole = day("cv_reflex", sun([1e3], interval_s=24 * HOUR))
    assert whole.changes[-1].after == ENDED
    assert whole.missed == ""


def test_a_phase_whose_end_is_met_at_first_light_is_said():
    phases = {"bulk": {"constant_voltage": {}, "until": {"soc": 0.1}}, "pulse": PULSES["pulse"]}
    found = day("cv_pulse", sun([30.0] * 4), phases=phases)
    assert "bulk skipped: soc 0.1, met as it began" in found.missed


def test_the_time_at_the_full_current_is_that_of_the_trace():
    """Steady: what is at the full current has it from its lowest to its highest; samples that change are either."""
    found = day("cc_cv", sun([40.0] * 4 + [12.0] * 4 + [40.0] * 12))
    lengths = np.diff(found.trace["Test Time / s"], prepend=0.0)
    full_a = found.trace["current_max_a"].max()
    full = found.trace["current_min_a"] > full_a * (1.0 - 1e-9)
    mixed = ~full & (found.trace["current_max_a"] > full_a * (1.0 - 1e-9))
    assert lengths[full].sum() >= 2400.0
    assert 0.0 <= found.current_limited_s - lengths[full].sum() <= lengths[mixed].sum()
    shares = found.current_limited_s + found.voltage_limited_s + found.supply_limited_s
    assert shares == pytest.approx(found.changes[-1].time_s, rel=1e-9)


@pytest.mark.parametrize("driver", ["edge", "averaged"])
def test_pulses_are_at_the_full_current_for_their_share(driver):
    """A millisecond of bulk, then 90 % of each fifth of a second; discharge and rest are no time of charging."""
    phases = {"bulk": PULSES["bulk"], "reflex": {"reflex": {}}}
    engine = EngineSettings(driver=driver)
    found = day("cv_reflex", sun([1e3], interval_s=600.0), engine=engine, frequency_hz=5.0, phases=phases)
    assert found.current_limited_s == pytest.approx(1e-3 + 0.9 * 600.0, rel=1e-9)
    assert found.voltage_limited_s == found.supply_limited_s == 0.0


def test_the_switches_of_a_pulsing_mode():
    change = day("cv_reflex", sun([30.0] * 8)).changes[-1]
    assert (change.closed.s2, change.closed.s3, change.closed.s4) == pytest.approx((1.0, 0.9, 0.05))
    assert change.pulses_hz == pytest.approx(90.0)


def test_the_end_of_a_charge_is_located_and_stays():
    found = day("cc_cv", sun([40.0] * 40))
    assert changes(found) == [(MODE_1, "surplus at least 2 W"), (ENDED, "stop: soc 0.99")]
    rows = found.trace["Test Time / s"]
    at = int(np.searchsorted(rows, found.changes[-1].time_s))
    assert found.trace["soc"][at] == pytest.approx(0.99, abs=1e-9)
    assert found.trace["Current / A"][at + 1 :] == pytest.approx(0.0, abs=1e-9)
    assert found.end_soc < 0.99


def test_temperature_changes_the_mode_where_it_is_reached():
    conditions = CONDITIONS.model_copy(update={"initial_soc": 0.2})
    phases = {
        "bulk": {"constant_voltage": {}, "until": {"elapsed_s": 3600, "temperature_c": 25.5}},
        "reflex": {"reflex": {}, "limit": {"voltage_v": "voltage_v"}},
    }
    found = day("cv_reflex", sun([40.0] * 9), conditions=conditions, phases=phases)
    assert changes(found)[1] == (MODE_2, "temperature 25.5 degC")
    at = found.changes[1].time_s
    assert 600.0 < at < 3600.0
    rows, warm = found.trace["Test Time / s"], found.trace["Surface Temperature / degC"]
    assert warm[rows <= at].max() <= 25.5
    assert warm[rows > at].min() > 25.49


@pytest.mark.parametrize(("kept_j", "mean_w"), [(None, 9.0), (0.0, 9.0), (0.005, 9.0 + 0.005 * 90.0), (1.0, 10.0)])
def test_the_bus_bridges_the_pauses_of_pulses(kept_j, mean_w):
    """10 W of sun, pulses of 90 % at 90 Hz: a pause leaves 11 mJ, of which the bus keeps what it can."""
    around = sun([10.0] * 12)
    around = around if kept_j is None else around._replace(kept_j=np.full(12, kept_j))
    found = day("cv_pulse", around, phases=PULSES)
    rows = slice(2, 50)
    power = np.diff(found.trace["Charging Energy / Wh"])[rows] * 3600.0 / np.diff(found.trace["Test Time / s"])[rows]
    assert power == pytest.approx(mean_w, rel=3e-5)


def test_course_by_course_is_the_same_sheet():
    """With nothing kept, legs of a course each make the day that legs of all courses make."""
    around = sun([30.0] * 4 + [0.5] * 3 + [30.0] * 20)
    one, other = (day("cv_reflex_hourly", each) for each in (around, around._replace(kept_j=np.zeros(27))))
    assert changes(one) == changes(other)
    assert [change.time_s for change in other.changes] == pytest.approx([change.time_s for change in one.changes])
    assert other.end_soc == pytest.approx(one.end_soc, rel=1e-6)
    assert len(one.changes) == 6


def test_without_sun_reflex_takes_nothing_out():
    found = day("cv_reflex", sun([30.0] * 8 + [0.0] * 8))
    dark = found.trace["Test Time / s"] > 4800.0 + 1e-6
    out = found.trace["Discharging Energy / Wh"]
    assert out[-1] == pytest.approx(out[~dark][-1], rel=1e-9)
    assert out[-1] > 0.1


def test_a_day_in_the_dark():
    found = day("cc_cv", sun([0.0] * 6))
    assert changes(found) == [(OFF, "first light")]
    assert found.charge_in_ah == pytest.approx(0.0, abs=1e-12)
    assert found.charging_s == 0.0


def test_a_resting_battery_follows_the_air():
    """Without current the temperature decays exactly: C dT/dt = (T_air - T)/R, half an hour at a time."""
    air = np.array([10.0, 30.0, 5.0])
    conditions = CONDITIONS.model_copy(update={"initial_soc": 0.3})
    found = day("cc_cv", sun([0.0] * 3, interval_s=1800.0, ambient_c=air), conditions=conditions)
    rows, warm = found.trace["Test Time / s"], found.trace["Surface Temperature / degC"]
    expected, tau_s = air[0], BATTERY.thermal.heat_capacity_j_k * BATTERY.thermal.resistance_k_w
    for step, outside in enumerate(air, start=1):
        expected = outside + (expected - outside) * np.exp(-1800.0 / tau_s)
        assert np.interp(1800.0 * step, rows, warm) == pytest.approx(expected, abs=2e-3)


def test_both_drivers_make_the_same_day():
    powers = [30.0, 8.0, 0.0, 20.0, 25.0]
    found = {
        driver: day("cv_reflex", sun(powers), engine=EngineSettings(driver=driver), frequency_hz=5.0)
        for driver in ("edge", "averaged")
    }
    assert found["averaged"].end_soc == pytest.approx(found["edge"].end_soc, abs=2e-7)
    assert found["averaged"].end_temperature_c == pytest.approx(found["edge"].end_temperature_c, abs=1e-5)


@pytest.mark.parametrize("name", MODES)
@pytest.mark.parametrize("cell", BATTERIES)
def test_every_battery_in_every_mode(cell, name):
    one = battery(cell)
    rate, voltage, soc = SUITED[cell]
    full_w = rate * one.capacity_ah * voltage
    conditions = CONDITIONS.model_copy(update={"initial_soc": soc})
    around = sun([full_w, 0.5, 0.4 * full_w], interval_s=20.0)
    found = charge_over_day(one, suited_mode(name, cell, bulk_s=15.0), around, conditions, EngineSettings())
    assert OFF in {change.after for change in found.changes}
    assert found.end_soc > soc
    of_path = dict(zip(found.energy["path"], found.energy["energy_j"], strict=True))
    assert abs(of_path["residual"]) < 1e-6 * of_path["electrical"]


def test_what_is_still_to_run_counts_what_was_run():
    from pipeline.charge.protocol import resolve
    from pipeline.day.charge import Place

    sheet = resolve(mode("cv_reflex_hourly"), 7.0)
    rest = still_to_run(sheet, Place(course=3, used_s=1000.0), 5e4)
    assert rest.courses[0].name == sheet.courses[3].name
    assert [course.until["elapsed_s"] for course in rest.courses[:2]] == [2600.0, 3600.0]
    assert rest.stop["elapsed_s"] == 5e4
    assert rest.stop["soc"] == sheet.stop["soc"]
