"""A charge that ends before it is where it was to go says which goal it missed, and why."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.charge.simulate import Supply
from tests.charge.samples import charge, settings, values
from tests.charge.test_exact import PLAIN, constant

CELL = Battery(**PLAIN)


@pytest.mark.parametrize(
    ("stop", "missed"),
    [
        ({"soc": 0.95}, "SOC 0.95 not reached, SOC 0.3778 at 1000 s: 1000 s time limit"),
        (
            {"soc": 0.95, "temperature_c": 25.5},
            "SOC 0.95 not reached, SOC 0.2389 at 500 s: 25.5 degC temperature limit",
        ),
        ({"voltage_v": 3.9}, "voltage 3.9 V not reached, SOC 0.3778 at 1000 s: 1000 s time limit"),
        (
            {"soc": 0.9, "voltage_drop_v": 0.02},
            "SOC 0.9 or voltage below its peak by 0.02 V not reached, SOC 0.3778 at 1000 s: 1000 s time limit",
        ),
        ({"soc": 0.3}, None),
        ({"soc": 0.3, "voltage_v": 3.9}, None),
        ({}, None),
        ({"temperature_c": 25.5}, None),
    ],
)
def test_a_goal_that_is_missed_is_named(stop, missed):
    found = values(charge(CELL, constant(1.0, 1000, **stop), settings(0.1)))
    assert found.get("missed") == missed


def test_hours_are_told_as_hours():
    found = values(charge(CELL, constant(0.01, 8 * 3600, soc=0.95), settings(0.1, sample_interval_s=600.0)))
    assert found["missed"] == "SOC 0.95 not reached, SOC 0.18 at 8 h: 8 h time limit"
    assert found["end_reason"] == "stop: elapsed 28800 s"


def test_a_supply_that_goes_out_is_no_silent_end():
    supply = Supply(np.array([0.0, 100.0]), np.array([3.0, 0.0]))
    found = values(charge(CELL, constant(1.0, 600, soc=0.5), settings(0.1), supply))
    assert found["missed"].endswith("600 s time limit")
    assert found["time_at_supply_limit_s"] == pytest.approx(600.0)


def test_phases_that_are_over_are_told_too():
    phases = {"only": {"constant_current": {"current_a": 1.0}, "until": {"elapsed_s": 60}}}
    mode = Mode(title="Short", phases=phases, stop={"elapsed_s": 1000, "soc": 0.9})
    found = values(charge(CELL, mode, settings(0.1)))
    assert found["missed"] == "SOC 0.9 not reached, SOC 0.1167 at 60 s: the last phase ended, 60 s time limit"


@pytest.mark.parametrize("edge", [0.3, 0.2])
def test_the_last_stage_may_reach_the_goal(edge):
    phases = {"stages": {"staged": {"currents_a": [2.0], "soc_edges": [edge]}}}
    mode = Mode(title="Staged", phases=phases, stop={"elapsed_s": 5000, "soc": 0.3})
    found = values(charge(CELL, mode, settings(0.1)))
    assert ("missed" in found) == (edge < 0.3)


def test_another_sign_of_full_in_the_last_phase_is_an_end():
    phases = {"hold": {"constant_voltage": {"voltage_v": 3.6, "max_current_a": 2.0}, "until": {"current_a": 0.5}}}
    mode = Mode(title="Held", phases=phases, stop={"elapsed_s": 5000, "soc": 0.9})
    found = values(charge(CELL, mode, settings(0.1)))
    assert found["end_reason"] == "current 0.5 A"
    assert "missed" not in found
