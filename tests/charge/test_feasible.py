"""What cannot be is refused before anything runs, what will not come is told: with battery, key, SOC and value."""

import math

import pytest

from pipeline.cell.records import Battery, Tabulated
from pipeline.charge.checks import check
from pipeline.charge.feasible import highest_v, notices, remarks, visited
from pipeline.charge.records import Mode
from pipeline.config.compose import compose_tree
from pipeline.config.planning import make_plan
from pipeline.config.study import study_from
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, load, settings, values
from tests.charge.test_exact import PLAIN

FLAT = {"soc": [0.0, 0.5, 1.0], "value": [3.0, 3.3, 3.5]}


def plain(**changes):
    return Battery(**PLAIN | {"cells_in_series": 1} | changes)


def sheet(volts=1.9, amperes=1.0, **stop):
    phases = {"charge": {"constant_voltage": {"voltage_v": volts, "max_current_a": amperes}}}
    return Mode(title="Held", phases=phases, stop={"elapsed_s": 9000.0} | stop)


@pytest.mark.parametrize("soc", [0, 0.02, 0.04])
def test_a_start_at_which_the_second_battery_cannot_rest_is_refused_in_the_plan(soc):
    value = "-inf" if soc == 0 else f"{12.26899 - 0.35110849384 * (1 - soc) / soc:.4g}"
    with pytest.raises(UserError) as told:
        study_from(compose_tree(["study=solar_reflex", f"charge.initial_soc={soc}"]))
    assert f"second_battery.open_circuit_voltage_v: {value} V at SOC {soc:g} of lead_acid_generic" in str(told.value)


def test_every_calibration_is_looked_at():
    words = ["study=lfp_cuckoo", "calibrations.no_entropy.series_resistance_ohm.scale=-1"]
    with pytest.raises(UserError, match=r"calibrations\.no_entropy"):
        study_from(compose_tree(words))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"open_circuit_voltage_v": {"soc": [0.0, 0.1, 0.4, 0.5, 1.0], "value": [3.0, 3.1, 33.1, 3.3, 3.5]}},
            r"battery\.open_circuit_voltage_v: 3\.3 V at SOC 0\.5 of plain, .* it may not fall while charging, and "
            r"rests at 33\.1 V at SOC 0\.4",
        ),
        (
            {"open_circuit_voltage_v": {"soc": [0.0, 0.3, 0.31, 1.0], "value": [3.0, 3.2, 0.1, 3.5]}},
            r"battery\.open_circuit_voltage_v: 0\.1 V at SOC 0\.31 of plain",
        ),
        (
            {"charge_transfer": {"exchange_current_a": {"polynomial": [0.5, -1.0]}}},
            r"charge_transfer\.exchange_current_a",
        ),
    ],
)
def test_a_curve_is_looked_at_over_all_that_is_visited(changes, message):
    with pytest.raises((UserError, ValueError), match=message):
        check(plain(**changes), sheet(3.6), settings(0.1))


def test_what_is_not_visited_may_be_as_it_likes():
    dip = {"soc": [0.0, 0.05, 0.1, 1.0], "value": [3.0, 3.3, 3.1, 3.5]}
    check(plain(open_circuit_voltage_v=dip), sheet(3.6), settings(0.2))
    with pytest.raises(UserError, match=r"3\.1 V at SOC 0\.1"):
        check(plain(open_circuit_voltage_v=dip), sheet(3.6), settings(0.03))
    assert visited(plain(), sheet(soc=0.7), settings(0.2)) == (0.2, 0.7)
    knobs = {"charge_a": 1.0, "charge_share": 0.4, "discharge_a": 2.0, "discharge_share": 0.4, "frequency_hz": 1.0}
    emptying = Mode(title="E", phases={"only": {"reflex": {}}}, stop={"elapsed_s": 10.0}, **knobs)
    assert visited(plain(), emptying, settings(0.2)) == (0.0, 1.0)


@pytest.mark.parametrize("pairs", [{}, {"one": {"resistance_ohm": 0.02, "time_constant_s": 5.0}}])
def test_no_series_resistance_under_a_held_voltage_is_refused(pairs):
    bare = plain(series_resistance_ohm=0.0, pairs=pairs)
    with pytest.raises(UserError, match=r"phases\.charge: plain has a series_resistance_ohm of 0 ohm at SOC 0\.1"):
        check(bare, sheet(), settings(0.1))
    steady = Mode(title="CC", phases={"a": {"constant_current": {"current_a": 1.0}}}, stop={"elapsed_s": 60.0})
    assert values(charge(bare, steady, settings(0.1)))["end_time_s"] == 60.0


def test_a_voltage_that_does_not_come_is_told_with_what_does():
    """8 Ah LiFePO4 at 1C to 3.65 V: full at 3.45 V plus what its resistances take, and the tail is never met."""
    phases = {"charge": {"constant_voltage": {}, "until": {"current_c_rate": 0.05}}, "rest": {"rest": {}}}
    mode = Mode(title="CC", max_current_c_rate=1.0, voltage_v=3.65, phases=phases, stop={"elapsed_s": 9000.0})
    used = battery("lfp_8ah")
    ohm = 0.74 * (0.0048 + 0.0040)
    assert highest_v(used, 8.0, 1.0, 25.0) == pytest.approx(3.45 + 8.0 * ohm, rel=1e-12)
    told = [line for line in notices(used, mode, settings(0.1)) if "not reached" in line]
    assert told == [
        "phases.charge.voltage_v: 3.65 V is not reached: with 8 A (1C) lfp_8ah comes to 3.502 V at SOC 1; its current "
        "never falls; rest would not be reached"
    ]
    found = charge(used, mode, settings(0.1))
    assert values(found)["end_reason"] == "stop: soc 1"
    assert found.trace["voltage_max_v"].max() == pytest.approx(3.502, abs=2e-3)


@pytest.mark.parametrize(("name", "rate"), [("nicd_2s_600mah", 0.5), ("lead_acid_12v7ah", 0.02)])
def test_the_voltage_that_is_come_to_is_that_of_a_charge_until_it_rests_there(name, rate):
    """Where the side reaction takes the whole current: hours of it, in a bath of one temperature."""
    used = battery(name)
    bath = used.model_copy(update={"thermal": used.thermal.model_copy(update={"heat_capacity_j_k": 1e12})})
    mode = Mode(title="Over", current_c_rate=rate, phases={"a": {"constant_current": {}}}, stop={"elapsed_s": 40000.0})
    found = charge(bath, mode, settings(0.9, sample_interval_s=3600.0)).trace["Voltage / V"][-1]
    bound = highest_v(used, rate * used.capacity_ah, 1.0, 25.0)
    assert found == pytest.approx(bound, rel=2e-4)


def test_a_current_outside_the_usual_is_told_as_a_rate():
    used = battery("lead_acid_12v7ah").model_copy(update={"scaled_to_capacity_ah": 70.0})
    mode = Mode(**load("modes/cc_cv.yaml"))
    told = [line for line in notices(used, mode, settings(0.2)) if "usual" in line]
    assert told == [
        "phases.charge.max_current_a: 2.1 A is 0.03C of lead_acid_12v7ah; usual are 0.05C to 0.3C, 3.5 to 21 A"
    ]
    assert not [line for line in notices(battery("lead_acid_12v7ah"), mode, settings(0.2)) if "usual" in line]


def test_the_plan_carries_what_is_told():
    told = make_plan([["study=nicd_grnn"]])["runs"][0]["remarks"]
    assert any("is 8C of nicd_2s_600mah; usual are 0.1C to 1C" in line for line in told)


def test_a_range_must_rise():
    with pytest.raises(ValueError, match="allowed is a range that rises"):
        plain(usual_c_rate=[0.3, 0.1])
    assert math.isclose(Tabulated(**FLAT).on_line(0.25), 3.15)


def test_a_scaled_battery_says_whose_its_numbers_are():
    own = battery("lead_acid_12v7ah")
    assert list(remarks(own, settings(0.2))) == []
    scaled = own.model_copy(update={"scaled_to_capacity_ah": 20.0})
    [told] = remarks(scaled, settings(0.2))
    assert told.startswith("scaled_to_capacity_ah: 20 Ah; every other number of lead_acid_12v7ah is that of 7 Ah")
    # What is told is what the engine computes with.
    one, other = (highest_v(each, 1e-3 * each.capacity_in_use_ah, 0.5, 25.0) for each in (own, scaled))
    assert other == pytest.approx(one, rel=1e-12)
    assert "resistances count 0.35 times, its heat capacity 2.86 times" in told


def test_resistances_that_do_not_follow_temperature_are_told_where_it_matters():
    used = battery("lead_acid_12v7ah")
    assert not any(used.warmths)
    assert list(remarks(used, settings(0.2, ambient_c=34.0))) == []
    [told] = remarks(used, settings(0.2, ambient_c=-10.0))
    assert "at -10 degC the resistances of lead_acid_12v7ah are those of 25 degC" in told
    law = {"activation_energy_j_mol": 2e4, "reference_temperature_c": 25.0}
    warm = Battery.model_validate(used.model_dump(by_alias=True) | {"series_resistance_temperature": law})
    assert list(remarks(warm, settings(0.2, ambient_c=-10.0))) == []


def test_a_resistance_in_the_wrong_unit_is_told():
    slip = battery("lead_acid_12v7ah").model_copy(update={"series_resistance_ohm": 2.0})
    told = [line for line in notices(slip, sheet(volts=14.4, amperes=2.1), settings(0.2)) if "at rest" in line]
    assert told == [
        "phases.charge.max_current_a: 2.1 A takes 25.2 V over the series resistance of lead_acid_12v7ah, which has "
        f"{6 * 2.1483:.3g} V at rest; series_resistance_ohm is that of a cell, in ohm"
    ]
    for name in ("lead_acid_12v7ah", "lfp_8ah", "nicd_2s_600mah"):
        lines = notices(battery(name), sheet(volts=99.0, amperes=battery(name).capacity_ah), settings(0.2))
        assert not [line for line in lines if "at rest" in line]
