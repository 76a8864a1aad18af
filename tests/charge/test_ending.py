"""A charge that ends before it is where it was to go says which goal it missed, and why."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.charge.simulate import Supply
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, settings, values
from tests.charge.test_exact import PLAIN, constant

CELL = Battery(**PLAIN)


@pytest.mark.parametrize(
    ("stop", "missed"),
    [
        ({"soc": 0.95}, "SOC 0.95 not reached, stopped by the 1000 s time limit at SOC 0.3778"),
        (
            {"soc": 0.95, "temperature_c": 25.5},
            "SOC 0.95 not reached, stopped by the 25.5 °C temperature limit after 500 s at SOC 0.2389",
        ),
        ({"voltage_v": 3.9}, "voltage 3.9 V not reached, stopped by the 1000 s time limit at SOC 0.3778"),
        (
            {"soc": 0.9, "voltage_drop_v": 0.02},
            "SOC 0.9 or voltage below its peak by 0.02 V not reached, stopped by the 1000 s time limit at SOC 0.3778",
        ),
        ({"soc": 0.3}, ""),
        ({"soc": 0.3, "voltage_v": 3.9}, ""),
        ({}, ""),
        ({"temperature_c": 25.5}, ""),
    ],
)
def test_a_goal_that_is_missed_is_named(stop, missed):
    found = values(charge(CELL, constant(1.0, 1000, **stop), settings(0.1)))
    assert found["missed"] == missed


def test_hours_are_told_as_hours():
    found = values(charge(CELL, constant(0.01, 8 * 3600, soc=0.95), settings(0.1, sample_interval_s=600.0)))
    assert found["missed"] == "SOC 0.95 not reached, stopped by the 8 h time limit at SOC 0.18"
    assert found["end_reason"] == "stop: elapsed 28800 s"


def test_a_supply_that_goes_out_is_no_silent_end():
    supply = Supply(np.array([0.0, 100.0]), np.array([3.0, 0.0]))
    found = values(charge(CELL, constant(1.0, 600, soc=0.5), settings(0.1), supply))
    assert found["missed"].endswith(", the supply at its limit for 600 s")
    assert found["time_at_supply_limit_s"] == pytest.approx(600.0)


def test_phases_that_are_over_are_told_too():
    phases = {"only": {"constant_current": {"current_a": 1.0}, "until": {"elapsed_s": 60}}}
    mode = Mode(title="Short", phases=phases, stop={"elapsed_s": 1000, "soc": 0.9})
    found = values(charge(CELL, mode, settings(0.1)))
    assert (
        found["missed"] == "SOC 0.9 not reached, the last phase ended by its 60 s time limit after 60 s at SOC 0.1167"
    )


@pytest.mark.parametrize("edge", [0.3, 0.2])
def test_the_last_stage_may_reach_the_goal(edge):
    phases = {"stages": {"staged": {"currents_a": [2.0], "soc_edges": [edge]}}}
    mode = Mode(title="Staged", phases=phases, stop={"elapsed_s": 5000, "soc": 0.3})
    found = values(charge(CELL, mode, settings(0.1)))
    assert (found["missed"] != "") == (edge < 0.3)


def test_another_sign_of_full_in_the_last_phase_is_an_end():
    phases = {"hold": {"constant_voltage": {"voltage_v": 3.6, "max_current_a": 2.0}, "until": {"current_a": 0.5}}}
    mode = Mode(title="Held", phases=phases, stop={"elapsed_s": 5000, "soc": 0.9})
    found = values(charge(CELL, mode, settings(0.1)))
    assert found["end_reason"] == "current 0.5 A"
    assert found["missed"] == ""


CC = {"constant_current": {"current_a": 8.0}, "until": {"voltage_v": 3.65}}
CV = {"constant_voltage": {"voltage_v": 3.65, "max_current_a": 8.0}}
TAIL = {"current_a": 0.4}
AFTER = "the battery was full after 3240 s at SOC 1"
FULL = f"current 0.4 A not reached, {AFTER}, 8 A flowing"


def lithium(soc, stop, **phases):
    mode = Mode(title="Lithium", phases=phases, stop={"elapsed_s": 14400} | stop)
    return charge(battery("lfp_8ah"), mode, settings(soc))


@pytest.mark.parametrize(
    ("stop", "phases", "missed"),
    [
        ({}, {"cc": CC, "cv": CV | {"until": TAIL}}, f"{FULL}; cv never ran"),
        (TAIL, {"cc": CC, "cv": CV}, f"{FULL}; cv never ran"),
        (TAIL, {"cc_cv": CV}, f"{FULL}; cc_cv never held its 3.65 V"),
        ({}, {"cc_cv": CV | {"until": TAIL}}, f"{FULL}; cc_cv never held its 3.65 V"),
        (
            {},
            {"cc": CV},
            f"4 h time limit not reached, {AFTER}; cc never held its 3.65 V",
        ),
        ({"soc": 0.5}, {"cc": CC, "cv": CV | {"until": TAIL}, "float": {"rest": {}}}, "cv and float never ran"),
        ({"soc": 0.5}, {"cc": CC}, ""),
    ],
)
def test_full_in_place_of_the_goal_is_told(stop, phases, missed):
    """The case of an 8 Ah cell whose model is full below 3.65 V: it ended with 8 A flowing, and nothing said so."""
    assert values(lithium(0.1, stop, **phases))["missed"] == missed


@pytest.mark.parametrize(
    ("until", "told"),
    [
        ({"voltage_v": 3.1}, "voltage 3.1 V"),
        ({"soc": 0.15}, "soc 0.15"),
        ({"temperature_c": 20.0}, "temperature 20 degC"),
    ],
)
def test_a_phase_that_is_over_is_skipped_and_told(until, told):
    """A pre-charge to 3.1 V on a battery at 3.2 V: chargers skip it."""
    phases = {"pre_charge": {"constant_current": {"current_a": 0.8}, "until": until}, "charge": CV}
    made = lithium(0.2, {"soc": 0.6}, **phases)
    assert made.phases["end_reason"][0] == f"{told}, met as it began"
    assert values(made)["missed"] == f"pre_charge skipped: {told}, met as it began"
    plain = values(lithium(0.2, {"soc": 0.6}, charge=CV))
    for name in ("end_time_s", "charge_in_ah", "energy_in_wh"):
        assert values(made)[name] == plain[name]


def test_a_sheet_that_is_over_as_a_whole_is_refused():
    first = {"constant_current": {"current_a": 0.8}, "until": {"voltage_v": 3.1}}
    second = {"constant_current": {"current_a": 8.0}, "until": {"soc": 0.2}}
    with pytest.raises(UserError, match=r"phases\.first\.until\.voltage_v: 3\.1 V is met at the start.* rests at 3\.2"):
        lithium(0.3, {}, first=first, second=second)


def test_a_float_below_the_tail_is_skipped_where_its_end_is_met():
    """Nothing flows as the float begins, its voltage below that of the battery."""
    phases = {
        "bulk": {"constant_voltage": {"voltage_v": 14.4, "max_current_a": 2.1}, "until": {"current_a": 1.0}},
        "float": {"constant_voltage": {"voltage_v": 13.2, "max_current_a": 2.1}, "until": {"current_a": 0.05}},
    }
    mode = Mode(title="Float", phases=phases, stop={"elapsed_s": 40000})
    found = values(charge(battery("lead_acid_12v7ah"), mode, settings(0.8)))
    assert found["missed"] == "float skipped: current 0.05 A, met as it began"


def test_stages_below_the_start_and_turns_of_a_repeated_sheet():
    stages = {"stages": {"staged": {"currents_a": [8.0, 7.0, 6.0], "soc_edges": [0.2, 0.3, 0.4]}}}
    found = values(lithium(0.25, {}, **stages))
    assert found["missed"] == "stages 1 skipped: soc 0.2, met as it began"
    phases = {
        "on": {"constant_current": {"current_a": 8.0}, "until": {"elapsed_s": 60}},
        "off": {"rest": {}, "until": {"elapsed_s": 60}},
    }
    mode = Mode(title="Turns", phases=phases, repeat=50, stop={"elapsed_s": 14400, "soc": 0.3})
    assert values(charge(battery("lfp_8ah"), mode, settings(0.25)))["missed"] == ""
